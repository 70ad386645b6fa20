#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/outcome.h"
#include "estimate/delay_pose.h"
#include "types/power.h"
#include "types/result.h"
#include "types/site.h"

namespace vildar {

/// What one of two photodiodes received of a vehicle that comes toward both.
struct DelaySide {
  std::vector<PowerBlock> blocks;  ///< of one length; ambient not removed
  Uncertain ambient_w;
  double passed_s = 0.0;  ///< where the light of the vehicle ends, cut off or not
};

/// Two photodiodes at about the same height and lateral place, looking about the same way along the
/// road, one up the road from the other. But for what PairPose says both receive the same function
/// of the vehicle's distance ahead of them, whatever lamp and law it is, so the time between like
/// powers is the baseline over the speed.
struct DelayProblem {
  DelaySide near, far;  ///< `far` stands up the road: it is passed first
  PairPose pose;
  Uncertain log_ratio;  ///< ln of the gain of `far` over that of `near`; std 0: known
  /// Times at which the speed is asked for; where none of the light is, the nearest that is.
  double asked_from_s = -INFINITY, asked_to_s = INFINITY;
};

/// Of the ratio of gains: from here on what two photodiodes receive unlike matters more than noise,
/// and is sought with the speed.
constexpr double kUnlikeStd = 0.005;

/// The shape of the far, faint part of the pulses, which tells the acceleration, is known less well
/// than its noise says. This doubt of it turns the motion about DelayFit::surest_s.
constexpr double kDelayAccelerationDoubt_mps2 = 0.3;

struct DelayFit {
  SpeedEstimate speed;    ///< where of the times asked for it is known best; positive: oncoming
  double surest_s = 0.0;  ///< where of all times of the light noise leaves the speed known best
  double acceleration_mps2 = 0.0, acceleration_std_mps2 = 0.0;
  /// Of speed and acceleration at the speed's time, without kDelayAccelerationDoubt_mps2 and drift.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();
  /// Part of the speed's sigma: the driver's way to the side, of 0.03 m/s rms, changes the light.
  double drift_std_mps = 0.0;
  /// Of the speed without that part, which is one for all that is seen of a vehicle.
  double own_std_mps() const {
    return std::sqrt(speed.std_mps * speed.std_mps - drift_std_mps * drift_std_mps);
  }
  double log_ratio = 0.0, log_ratio_std = 0.0;
  double gain_chi2 = 0.0;     ///< by how much gain or mismatch strain what was said
  double chi2_per_dof = 0.0;  ///< by the blocks' own sigmas
  double sigma_factor =
      1.0;                ///< by which scatter and correlation of the residuals widened the sigma
  int pieces = 0;         ///< of the curve fitted to the pulse
  int common_lights = 0;  ///< steps of light without delay beside it
  /// By how much chi-square falls once the acceleration may wander, in units of the noise.
  double wander_chi2 = 0.0;
  double mean_acceleration_mps2 = 0.0;  ///< over the light
  double bend_mps = 0.0;  ///< how far the speed goes from that of a constant acceleration
  /// Two sigmas less than the hardest braking and speeding up at any time; not negative.
  double surely_brakes_mps2 = 0.0, surely_speeds_up_mps2 = 0.0;
};

/// Speed and acceleration from two pulses, their common shape being a free smooth curve with as
/// many pieces as the data ask for. The acceleration, of which 0 +- 1.5 m/s^2 is known beforehand,
/// may wander while the light lasts. Where the ratio of gains is uncertain, a mismatch that grows
/// with the angle off the road is allowed for: of the same size at 0.35 rad. From kUnlikeStd on it
/// is sought with the speed as well, and the speed lies between where both ways agree. A gain or a
/// mismatch that strains what was said of it is taken to be known five times worse. Light that
/// comes or goes on both at once, fainter than the vehicle's, is fitted beside it: follow().
/// Misses: too_few_samples, below_noise, not_converged, bad_fit (the pulses are not alike),
/// too_uncertain (the delay is not told from none), sensors_contradict (a gain unlike what was
/// said).
Outcome<DelayFit> fit_delay(const DelayProblem& problem);

}  // namespace vildar
