#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace vildar {

/// Where a vehicle's lamps stand in the image, left and right as seen in it; either may be absent.
struct LampPixels {
  std::optional<Eigen::Vector2d> left_px, right_px;
  bool any() const { return left_px || right_px; }
  /// Of the pair, or the one lamp there is. Requires any().
  Eigen::Vector2d middle_px() const {
    if (left_px && right_px) return 0.5 * (*left_px + *right_px);
    return left_px ? *left_px : *right_px;
  }
};

/// A speed as a run states it; what the file leaves empty is absent.
struct StatedSpeed {
  double t_ref_s = 0.0;
  double speed_mps = 0.0;
  std::optional<double> std_mps, lo95_mps, hi95_mps;
};

/// Exactly one of `speed` and `withheld` (the reason, snake_case) is there.
struct StatedOutcome {
  std::optional<StatedSpeed> speed;
  std::string withheld;
};

struct StatedMethod {
  std::string method;
  StatedOutcome outcome;
};

/// One row of tracks.csv.
struct RunSighting {
  std::int64_t frame = 0;
  LampPixels lamps;
  std::optional<double> azimuth_rad, range_m;
  std::optional<double> t_s = {};
};

struct RunVehicle {
  std::string track_id;
  std::string direction;
  StatedOutcome outcome;
  double t_first_s = 0.0, t_last_s = 0.0;
  std::optional<double> range_ref_m;
  std::vector<RunSighting> sightings;  ///< in order of frame
  std::vector<StatedMethod> methods;
};

/// What a run wrote, vehicles in the order of speeds.csv.
struct RunFolder {
  std::vector<RunVehicle> vehicles;
  std::vector<std::string> notes;  ///< what was absent and therefore is not scored
};

/// Reads DIR/speeds.csv and, where they exist, tracks.csv and methods.csv. Throws InputError for a
/// file that does not hold to the contract. A track without a row in speeds.csv is a vehicle
/// withheld for the reason `not_in_speeds_csv`.
RunFolder read_run_folder(const std::filesystem::path& folder);

/// One row of truth_tracks.csv.
struct TruthSighting {
  std::int64_t frame = 0;
  double t_s = 0.0;
  LampPixels lamps;
  std::optional<double> x_m, y_m, range_m, speed_mps;
  bool occluded = false;
  bool visible() const { return lamps.any() && !occluded; }
};

struct TruthVehicle {
  std::string id;
  std::string direction, lane;  ///< empty where truth does not say
  double t_ref_s = 0.0;
  double speed_mps = 0.0;
  std::optional<double> acceleration_mps2;
  std::vector<TruthSighting> sightings;  ///< in order of time

  /// Interpolated between the sightings; outside them from the vehicle's own reference with
  /// constant acceleration, and absent where truth gives no acceleration.
  std::optional<double> speed_at(double t_s) const;
  /// Interpolated; absent outside the sightings.
  std::optional<double> range_at(double t_s) const;
  /// x and y in the road frame, interpolated; absent outside the sightings.
  std::optional<Eigen::Vector2d> place_at(double t_s) const;
};

/// Reads DIR/truth_vehicles.csv and DIR/truth_tracks.csv. Throws InputError.
std::vector<TruthVehicle> read_truth_folder(const std::filesystem::path& folder);

}  // namespace vildar
