#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "estimate/trajectory.h"
#include "estimate/vehicle.h"

namespace vildar {

/// The gain of a photodiode relative to the site's first, as one pass tells it.
struct PassGainRatio {
  int photodiode = 0;      ///< index in the site
  double log_off = 0.0;    ///< ln of the ratio over the site's mean
  double std = 0.0;        ///< of log_off, posterior
  double prior_std = 0.0;  ///< that the site gave
};

struct JointFit {
  Trajectory trajectory;  ///< the camera's, moved and sharpened by the photodiodes
  double power_chi2_per_block = 0.0;
  std::int64_t samples = 0;                ///< photodiode samples behind the blocks used
  std::vector<PassGainRatio> gain_ratios;  ///< those that the site gives a std; from the first
};

/// Bearings and photodiode power together. The lamp's beam multiplies the channel law by a smooth
/// function of the angles toward the photodiode with loose priors, so that a beam unlike the law's
/// cannot bend the trajectory; gain, exponent, background, drift and time offset are unknowns with
/// the site's priors. Starts from the camera's own fit and the site's time offset; where that does
/// not fit and its std allows, from others up to 3 s away too. Misses: several_vehicles,
/// below_noise, too_few_samples, bad_fit (the power does not fit the model), sensors_contradict (it
/// pulls the trajectory off the bearings).
Outcome<JointFit> fit_joint(const Trajectory& camera_only, const Site& site,
                            std::span<const VehiclePower> power, double from_s, double to_s);

/// The same from one time offset alone, `later_s` greater than the site's mean, which stays that of
/// the prior.
Outcome<JointFit> fit_joint_from(const Trajectory& camera_only, const Site& site,
                                 std::span<const VehiclePower> power, double from_s, double to_s,
                                 double later_s);

}  // namespace vildar
