#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "optics/camera.h"
#include "optics/ego_motion.h"
#include "track/attitude.h"
#include "types/camera_turn.h"
#include "types/site.h"

namespace vildar {

/// Turns of a camera that drives, frame by frame, from the lights that stand in the world beside
/// its road; see solve_turns.
class DriveAttitude {
 public:
  /// Needs site.camera and site.ego.
  explicit DriveAttitude(const Site& site);

  /// Frames come in order of time, each before what was seen in it.
  void begin(std::int64_t frame, double time_s);
  /// What one light has shown since the last call; `light` is any number that stays with it.
  void add(std::uint64_t light, const std::vector<StaticSighting>& sightings);

  /// Turns in a vehicle's frames, ascending, from all lights seen in them: where none was, none
  /// with the sigma of the movement in others. Nothing where no light stands, where the camera does
  /// not shake by more than the lights can tell, and in frames that are forgotten.
  std::vector<std::optional<CameraTurn>> turns_in(std::span<const std::int64_t> frames) const;

  /// Frames before this one are not asked for any more.
  void forget_before(std::int64_t frame);

 private:
  struct Seen {
    std::uint64_t light;
    StaticSighting sighting;
  };
  /// A frame, and where the camera's vehicle was.
  struct Moment {
    std::int64_t frame = 0;
    DrivenPose pose;
    std::vector<Seen> seen;
  };

  /// Of the first moment at or after a frame.
  std::size_t index_of(std::int64_t frame) const;
  std::vector<CameraTurn> turns_between(std::size_t from, std::size_t to) const;

  Camera camera_;
  Eigen::Vector3d pose_std_rad_;
  double focal_px_;
  EgoMotion ego_;
  std::deque<Moment> moments_;
};

}  // namespace vildar
