#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "estimate/trajectory.h"
#include "estimate/vehicle.h"

namespace vildar {

/// What the passes of a site share (its clock, its gains) or have alike (their beams), as one of
/// them tells it.
struct SharedLight {
  enum class Kind { time_offset_s, beam, log_gain_ratio } kind = Kind::time_offset_s;
  int index = 0;           ///< of the beam's coefficient, or the photodiode in the site
  double off = 0.0;        ///< from the prior's mean
  double prior_std = 0.0;  ///< that it was given
  double by_scale = 0.0;   ///< how it follows the ln of all lengths of the pass
};

struct JointFit {
  Trajectory trajectory;  ///< the camera's, moved and sharpened by the photodiodes
  double power_chi2_per_block = 0.0;
  std::int64_t samples = 0;  ///< photodiode samples behind the blocks used
  std::vector<SharedLight> shared;
  Eigen::MatrixXd shared_covariance;  ///< posterior, of what `shared` lists
};

/// Bearings and photodiode power together. The lamp's beam multiplies the channel law by a smooth
/// function of the angles toward the photodiode with loose priors, so that a beam unlike the law's
/// cannot bend the trajectory; gain, exponent, background, drift and time offset are unknowns with
/// the site's priors. Starts from the camera's own fit.
/// Misses: several_vehicles, below_noise, too_few_samples, bad_fit (the power does not fit the
/// model), sensors_contradict (it pulls the trajectory off the bearings).
Outcome<JointFit> fit_joint(const Trajectory& camera_only, const Site& site,
                            std::span<const VehiclePower> power, double from_s, double to_s);

}  // namespace vildar
