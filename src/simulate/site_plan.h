#pragma once

#include <optional>
#include <string>
#include <vector>

#include "types/result.h"
#include "types/site.h"

namespace vildar::simulate {

/// What is not in the site file but decides how well it measures.
struct PlanOptions {
  std::vector<double> speeds_kmh{30.0, 50.0, 90.0, 130.0};
  double frame_rate_hz = 30.0;
  double centroid_sigma_px = 0.15;
  double farthest_m = 80.0;  ///< range at which lamps are first told apart and followed
  double photodiode_rate_hz = 1000.0;
  double photodiode_snr_db = 40.0;  ///< 20 log10 of the power from 60 m over the noise of a sample

  /// Every violation at once: field, value, rule.
  std::vector<std::string> problems() const;
};

/// What the program would make of a typical vehicle of one lane at one speed.
struct PlanRow {
  std::string lane;
  double speed_mps = 0.0;
  double from_m = 0.0, to_m = 0.0;  ///< range over which the camera sees it; 0 without a camera
  double seconds = 0.0;             ///< for which it is seen
  VehicleResult result;             ///< speed or reason, sigma, budget, methods
  /// Where the photodiodes without the camera would be surer: of another time, that at which the
  /// vehicle passes them.
  std::optional<SpeedEstimate> light_alone;
};

/// Expected sigmas of a site before anything is installed: a vehicle of the site's mean sizes
/// drives through each lane a few times, with the noise that bearings and power would have; the
/// estimator says what it knows, and the middle pass counts. Photodiodes count where the site has
/// them; of two or more beside a camera what they would give without it is told, too.
/// Throws std::invalid_argument for a dashcam (`ego`) or a site without lanes.
std::vector<PlanRow> plan_site(const Site& site, const PlanOptions& options);

}  // namespace vildar::simulate
