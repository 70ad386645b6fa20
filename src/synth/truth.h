#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "synth/scenario.h"

namespace vildar {

/// One vehicle in one frame (without a camera: every 10 ms).
struct TruthTrackRow {
  std::int64_t frame = 0;
  double time_s = 0.0;
  std::size_t vehicle = 0;
  /// Left and right as seen in the image, at each lamp's own row time; nothing outside the image or
  /// where the lamp looks away. A single lamp is left.
  std::optional<Eigen::Vector2d> left_px, right_px;
  Eigen::Vector2d place_m = Eigen::Vector2d::Zero();
  double speed_mps = 0.0;
  double acceleration_mps2 = 0.0;
  bool occluded = false;  ///< other bodies hide every lamp that the image would show
  bool seen = false;      ///< by the camera, or without one by a photodiode
};

/// Vehicles that no sensor sees at any time have no rows.
std::vector<TruthTrackRow> truth_tracks(const Scenario& scenario);

/// truth_tracks.csv and truth_vehicles.csv of the contract; t_ref_s is the middle of the time in
/// which a vehicle is seen.
std::string truth_tracks_csv(const Scenario& scenario, const std::vector<TruthTrackRow>& rows);
std::string truth_vehicles_csv(const Scenario& scenario, const std::vector<TruthTrackRow>& rows);

}  // namespace vildar
