#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "detect/detector.h"

namespace vildar {

/// A piece of a frame about one lamp, or two whose light overlaps, and no other light.
struct LampCrop {
  struct Tables {
    std::vector<float> linear, rounding;
  };
  FrameLight light;                      ///< of the piece alone
  std::shared_ptr<const Tables> tables;  ///< behind `light`
  std::vector<LampGuess> lamps;          ///< in the piece's pixels
  int lamp_id = 0;                       ///< of the first lamp, the same while it is followed
  std::int64_t frame = 0;
};

/// Chooses lamps that stand apart from the frames of clips, evenly over how large an area of them
/// clips, over lamps and over time.
class CropCollector {
 public:
  /// `exposure_s`, where known, tells how far a lamp moves while it is exposed; else it is taken to
  /// be as long as the time between frames.
  void begin_clip(std::optional<double> exposure_s);
  void add(const Frame& frame, const SeenLights& seen);

  /// What was chosen: at most some 50 crops of each size of clipped area.
  std::vector<LampCrop> crops() const;
  std::int64_t frames() const { return frames_; }
  /// Lamps of frames that were not taken, by reason.
  const std::map<std::string, std::int64_t>& left_out() const { return left_out_; }

 private:
  struct Followed {
    Eigen::Vector2d centre_px;
    int id;
  };
  /// Crops of one lamp at one size, thinned as they grow many.
  struct Kept {
    std::int64_t seen = 0, stride = 1;
    std::vector<LampCrop> crops;
  };
  struct Candidate {
    bool usable = false;
    double rim_px = 0.0, size_px = 1.0, reach_px = 0.0;
    int id = -1;
    std::optional<Eigen::Vector2d> moved_px;  ///< since the last frame
  };
  void follow(const Frame& frame, const SeenLights& seen);
  std::optional<std::vector<std::size_t>> group_of(const SeenLights& seen, std::size_t first) const;
  const char* fault_of(const SeenLights& seen, const std::vector<std::size_t>& group) const;
  void keep(const SeenLights& seen, const std::vector<std::size_t>& group);

  std::optional<double> exposure_s_;
  std::optional<CameraTime> before_at_;
  double exposed_share_ = 1.0;  // of the time since the last frame
  std::vector<Followed> before_;
  std::vector<Candidate> now_;
  int next_id_ = 0;
  std::int64_t frames_ = 0;
  std::shared_ptr<const LampCrop::Tables> tables_;
  std::map<std::pair<int, int>, Kept> kept_;  // by size of the clipped area, and lamp
  std::map<std::string, std::int64_t> left_out_;
};

}  // namespace vildar
