#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace vildar {

/// A light that stands in the world as a moving camera saw it in one frame.
struct PassedLight {
  std::size_t frame = 0, light = 0;                    ///< counted from zero
  double time_s = 0.0;                                 ///< of its row
  Eigen::Vector2d camera_m = Eigen::Vector2d::Zero();  ///< ground place of the camera at that time
  double heading_rad = 0.0;  ///< of its vehicle, anticlockwise, in the frame of these places
  Eigen::Vector2d at = Eigen::Vector2d::Zero();  ///< undistorted x/z, y/z
  double sigma = 1.0;                            ///< of the same
};

struct TurnProblem {
  Eigen::Matrix3d camera_from_road = Eigen::Matrix3d::Identity();  ///< mean pose of the site
  Eigen::Vector3d pose_std_rad = Eigen::Vector3d::Zero();          ///< of it, camera axes
  std::size_t frames = 0, lights = 0;
  std::vector<PassedLight> sightings;
};

/// Turns of the camera about its axes (right, down, forward) from its mean pose, as in CameraTurn.
struct TurnSolution {
  std::vector<Eigen::Vector3d> rotation_rad;  ///< by frame; none where no light was seen
  std::vector<Eigen::Matrix3d> covariance;    ///< but for what all frames have in common
  Eigen::Vector3d mean_std_rad = Eigen::Vector3d::Zero();  ///< of that
  Eigen::Vector3d std_rad = Eigen::Vector3d::Zero();       ///< of the turns themselves
  Eigen::Array3d crossings = Eigen::Array3d::Zero();       ///< of their mean
};

/// A point that stands moves through the picture of a camera whose way is known as that way
/// dictates, but for the point's own place: what all lights move by beside is the camera's turn.
/// Places, mean pose, a steady drift of the heading and the turn of every frame are fitted
/// together, the turns with a scatter about zero that is found with them. Lights that scatter by
/// more than their sigmas, as those do that move by themselves, count as much less. Nothing where
/// no light was seen often enough.
std::optional<TurnSolution> solve_turns(const TurnProblem& problem);

}  // namespace vildar
