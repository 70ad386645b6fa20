#pragma once

#include <vector>

#include "types/blob.h"

namespace vildar {

/// Tells the frames that show what the frame before shows, as where a clip was given a higher rate:
/// all lights stand where they stood, though some were seen to move well beyond their noise. Two
/// pictures of one moment say no more than one of them, and say it for the wrong time.
class RepeatedFrames {
 public:
  /// Whether `frame` repeats the last one that did not. Frames in order of time. Lights that stand,
  /// or move within their noise, tell nothing: such a frame repeats none, nor does one in which a
  /// light stands anew that is seen about as sharply as those that moved.
  bool repeats(const BlobFrame& frame);

 private:
  struct Light {
    Eigen::Vector2d centre_px, sigma_px;
    Eigen::Vector2d velocity_px_per_s = Eigen::Vector2d::Zero();
    Eigen::Vector2d velocity_sigma_px_per_s = Eigen::Vector2d::Zero();
    double reach_px = 0.0;
    bool followed = false;  ///< it has a velocity
    int came_from = 0;      ///< how many of the frame before it may be
  };

  static std::vector<Light> lights_of(const BlobFrame& frame);
  void follow(std::vector<Light>& now, double duration_s) const;

  std::vector<Light> lights_;  ///< of the last frame that repeats none
  double time_s_ = 0.0;
};

}  // namespace vildar
