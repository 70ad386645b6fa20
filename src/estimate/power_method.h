#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/outcome.h"
#include "optics/channel.h"
#include "types/result.h"
#include "types/site.h"

namespace vildar {

/// Received light of one vehicle against time, background removed.
struct PowerSeries {
  std::vector<double> time_s;
  std::vector<double> power_w;
  double background_std_w = 0.0;  ///< of the background, one error for all samples
};

/// All that the paper's estimators take as known, with what it is known to.
struct PowerCase {
  PowerLaw law;
  double log_gain_std = 0.0;
  double exponent_std = 0.0;
  /// d ln K / d gamma, where K was fitted to this light for the gamma at hand.
  std::optional<double> log_gain_per_exponent;
  Eigen::Vector3d receiver_m = Eigen::Vector3d::Zero();
  Uncertain lateral_m;  ///< of the lane's path, as in path_point
  Uncertain lamp_height_m;
  double bend = 0.0;     ///< as in path_point
  Uncertain straight_m;  ///< to where the bend begins
  Uncertain radius_m;    ///< of the line y = 0, curved roads

  /// Perpendicular distance from the receiver to the line of motion, straight roads.
  double perpendicular_m() const;
  /// The lane's own radius, the paper's r_c.
  double lane_radius_m() const;
};

/// A vehicle's motion along its path.
struct PassMotion {
  double reference_s = 0.0;
  double speed_mps = 0.0;  ///< positive: closing
  double along_m = 0.0;    ///< path length from x = 0 at the reference
  double acceleration_mps2 = 0.0;
};

struct PowerSpeed {
  SpeedEstimate speed;   ///< at the middle of the series
  double range_m = 0.0;  ///< x in the road frame at that time
};

/// The paper's estimator for the road's kind, with a sigma that holds: scatter about the line
/// (correlated residuals counted as such), the priors of K, gamma, d and r_c and the background's
/// error carried through, what lamps unlike the law may do, and the error that the estimator itself
/// makes on a noise-free pass of the full model (cosine, offsets from the curve that it leaves
/// out). The 95 % interval is log-normal. Misses: those of the estimators, and outside_model where
/// its own error passes a quarter of the speed or the speed comes out negative.
Outcome<PowerSpeed> power_speed(const PowerSeries& series, const PowerCase& known);

/// What that estimator makes of the light, at its middle. Misses: those of the estimator, and
/// outside_model where the speed comes out negative.
Outcome<PassMotion> paper_motion(const PowerSeries& series, const PowerCase& known);

}  // namespace vildar
