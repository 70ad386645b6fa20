#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/outcome.h"
#include "types/vehicle_track.h"

namespace vildar {

/// A speed with its uncertainty. Lower and upper are the ends of the 95 % interval.
struct SpeedEstimate {
  double time_s = 0.0;  ///< clip time at which speed and range hold
  double speed_mps = 0.0;
  double std_mps = 0.0;
  double lo95_mps = 0.0;
  double hi95_mps = 0.0;
  std::int64_t samples_used = 0;
};

enum class Method : std::uint8_t {
  power_slope_camera,
  power_slope_photodiode,
  curved_angle_camera,
  curved_angle_photodiode,
  ml_photodiode,
  delay_photodiodes,
  geometry_camera,
  fused,
};
std::string_view name_of(Method method);
std::string_view name_of(Direction direction);
std::string_view name_of(LampKind kind);

/// One row of methods.csv.
struct MethodResult {
  Method method = Method::geometry_camera;
  Outcome<SpeedEstimate> speed = Miss::too_few_samples;
  std::int64_t samples = 0;  ///< offered to the method, also where it withheld
  std::string k_source;      ///< `site`, `bearings`, or empty
};

/// Where the sigma of a speed comes from: both relative to the speed, their squares add.
struct SpeedBudget {
  double shape = 0.0;  ///< what the data leave open with all lengths known
  double scale = 0.0;  ///< what the lengths known in metres leave open
  /// What fixes the scale, and its share of all information on it.
  std::map<std::string, double> scale_shares;
  /// How far each known quantity comes out over (positive) or under what was known of it, in
  /// standard deviations of that difference, as the likeliest thing that the vehicle may be;
  /// `acceleration` is positive where it speeds up. Those that nothing else tells are left out.
  std::map<std::string, double> prior_pulls;
};

/// One row of speeds.csv, and the methods behind it.
struct VehicleResult {
  int track_id = 0;
  Direction direction = Direction::oncoming;
  std::string lane;  ///< id in the site file; empty where none has 95 % of the probability
  double no_lane_probability = 0.0;  ///< that it drives in none of those told
  double t_first_s = 0.0;
  double t_last_s = 0.0;
  std::optional<Miss> withheld;
  SpeedEstimate speed;  ///< meaningful where not withheld
  std::optional<double> range_ref_m;
  std::optional<double> lateral_m;
  std::optional<double> acceleration_mps2;
  std::optional<double> closing_speed_mps;
  bool used_camera = false;
  bool used_photodiode = false;
  Method method = Method::geometry_camera;
  int n_frames = 0;
  std::int64_t n_pd_samples = 0;
  std::vector<MethodResult> methods;
  std::vector<std::string> warnings;
  std::optional<SpeedBudget> budget;           ///< speeds from a camera's trajectory
  std::map<std::string, double> chi2_per_dof;  ///< by sensor: `camera`, `photodiode`
};

/// One row of tracks.csv: a vehicle in a frame with what is known of it there.
struct TrackRow {
  int track_id = 0;
  VehicleSighting sighting;
  double time_s = 0.0;
  double intensity = 0.0;
  double intensity_std = 0.0;
  /// Road-frame bearings of the middle of the pair and of each lamp, [azimuth, elevation].
  std::optional<Eigen::Vector2d> bearing_rad, bearing_left_rad, bearing_right_rad;
  std::optional<double> range_m, range_std_m, speed_mps, speed_std_mps;
};

}  // namespace vildar
