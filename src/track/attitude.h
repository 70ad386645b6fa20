#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include <Eigen/Core>

#include "types/camera_turn.h"

namespace vildar {

/// Where a light that stands in the world was seen in one frame; undistorted pixels (RoadView).
struct StaticSighting {
  std::int64_t frame = 0;
  Eigen::Vector2d at_px = Eigen::Vector2d::Zero();
  double sigma_px = 1.0;
  double time_s = 0.0;  ///< of its row
};

/// Turns of a camera that stands in one place but shakes, frame by frame, from the lights that
/// stand in the world: each against the place it has had on average since it was first seen, so
/// that nothing drifts. Turns are relative to the mean pose so far, and shrunk to what the lights
/// can tell.
class Attitude {
 public:
  explicit Attitude(double focal_px) : focal_px_(focal_px) {}

  /// What one light that stands has shown since the last call, in order of frames; the first call
  /// for a light brings all it has shown. `light` is any number that stays with it.
  void add(std::uint64_t light, const std::vector<StaticSighting>& sightings);
  /// Solves for the turn of a frame after all its lights have been added.
  void solve(std::int64_t frame);

  /// Turn in a frame: where none of its lights was seen, none with the sigma of the movement in
  /// others. Nothing where the camera moves less than the lights can tell.
  std::optional<CameraTurn> at(std::int64_t frame) const;

  /// Frames before this one are not asked for any more.
  void forget_before(std::int64_t frame);

 private:
  struct Light {
    Eigen::Vector2d reference_px = Eigen::Vector2d::Zero();
    double frames = 0.0;     ///< behind the reference
    double error_px2 = 0.0;  ///< mean square of what the turns leave, per axis
  };
  struct Seen {
    std::uint64_t light;
    Eigen::Vector2d at_px;
    double sigma_px;
  };
  /// From the lights of one frame alone, relative to the references.
  struct Turn {
    Eigen::Vector3d rotation_rad = Eigen::Vector3d::Zero();
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  };
  /// Of one axis, over the frames whose lights tell of it.
  struct Movement {
    double frames = 0.0, sum_rad = 0.0, square_sum_rad2 = 0.0, noise_sum_rad2 = 0.0;
    double crossings = 0.0;  ///< of its mean
    bool above = false;
    double last_rad = 0.0, moved = 0.0;  ///< frames in which it was not as in the one before

    void add(double turn_rad, double noise_rad2, double still_rad);
    double mean_rad() const { return frames > 0.0 ? sum_rad / frames : 0.0; }
    double noise_rad2() const { return frames > 0.0 ? noise_sum_rad2 / frames : 0.0; }
    double variance_rad2() const;  ///< of the camera itself
    /// Whether that is movement of the camera, by more than `least_rad`.
    bool moves(double least_rad) const;
  };

  Turn turn_of(const std::vector<Seen>& seen) const;
  void follow(const std::vector<Seen>& seen, const Turn& turn);

  double focal_px_;
  std::map<std::uint64_t, Light> lights_;
  std::map<std::int64_t, std::vector<Seen>> seen_;
  std::map<std::int64_t, Turn> turns_;
  std::set<std::int64_t> changed_;  ///< frames with lights that no turn has seen yet
  std::array<Movement, 3> movement_;
};

}  // namespace vildar
