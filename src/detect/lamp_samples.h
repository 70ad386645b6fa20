#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "detect/frame_light.h"

namespace vildar {

struct LampGuess {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  double rim_px = 0.0;   ///< radius of the clipped area; 0 where nothing clips
  double size_px = 1.0;  ///< standard deviation of what is seen about the centre, an axis
  /// How far the picture moved during the exposure, px.
  Eigen::Vector2d motion_px = Eigen::Vector2d::Zero();
  std::optional<double> radius_px;   ///< of the disc, from an earlier picture
  std::optional<double> flux;        ///< from an earlier picture
  std::optional<double> background;  ///< in the middle of the lamps, from an earlier picture
};

/// A lamp about which enough is known: its light is taken off, and what it covers is left out.
struct OtherLamp {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  double radius_px = 0.0;
  double flux = 0.0;
  double core_px = 0.0;  ///< see LampFitter::core_px
};

/// Pixels, one number of each in every row.
struct PixelRows {
  std::vector<float> u_px, v_px;  ///< from LampSamples::origin_px
  std::vector<float> light;
  std::vector<float> place2;  ///< square of the share of the reach of the lamp that brought it in
  std::vector<float> keep;    ///< share of its information that counts: 1, less at coded rims, or 0

  void resize(std::size_t pixels);
};

/// Pixels about lamps that are fitted together: first those that do not clip, then those that do,
/// each kind filled up to a multiple of DiscImage::kBatch with pixels that do not count. Keeps its
/// buffers.
struct LampSamples : PixelRows {
  std::vector<float> others;  ///< light of other lamps; left 0
  std::size_t clear = 0;      ///< those that do not clip, filled up
  std::size_t used = 0;       ///< that count
  Eigen::Vector2d origin_px = Eigen::Vector2d::Zero();

  std::size_t size() const { return keep.size(); }

  /// Pixels within `reach_px` of each lamp, but not in the cores of others. Where there are more
  /// than a fit needs, every so many.
  void gather(const FrameLight& light, std::span<const LampGuess> guesses,
              std::span<const double> reach_px, std::span<const OtherLamp> others);

  /// Those further out than this share of the reach count no more.
  void keep_within(double share);

 private:
  /// Columns of a row that lie in a circle.
  struct Chord {
    int first, last;
  };
  void list_circles(std::size_t lamp, int v, std::span<const LampGuess> guesses,
                    std::span<const double> reach_px, std::span<const OtherLamp> others_in);
  template <class T>
  void take(const FrameLight& frame, int v, Chord columns, int every, double softened_px2);

  std::size_t clear_count_ = 0, clipped_count_ = 0;
  PixelRows clipped_;
  std::vector<Chord> left_out_,
      holes_;  // circles whose pixels do not count, or clip all but in code
};

}  // namespace vildar
