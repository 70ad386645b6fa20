#include "estimate/delay_joint.h"

#include <algorithm>
#include <cmath>

namespace vildar {

Outcome<JointFit> fit_with_delay(const Trajectory& camera_only, const DelayFit& delay,
                                 double time_std_s) {
  JointFit joint;
  joint.trajectory = camera_only;
  KnownMotion motion;
  motion.time_s = delay.speed.time_s;
  motion.value = {delay.speed.speed_mps, delay.acceleration_mps2};
  motion.covariance = delay.covariance;
  const Eigen::Vector2d turned(delay.speed.time_s - delay.surest_s, 1.0);
  motion.covariance += std::pow(kDelayAccelerationDoubt_mps2, 2) * turned * turned.transpose();
  motion.covariance(0, 0) += std::pow(delay.acceleration_mps2 * time_std_s, 2);
  GeometryProblem& problem = joint.trajectory.problem;
  problem.priors.motion = motion;
  const auto outcome = fit_geometry(problem, camera_only.fit.parameters);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) return *miss;
  joint.trajectory.fit = std::get<GeometryFit>(outcome);
  if (auto change = find_motion_change(problem, joint.trajectory.fit, camera_only.frames))
    joint.trajectory.change = std::move(*change);
  constexpr double kMostPull = 10.0;  // half a chi-square of two degrees of freedom
  if (joint.trajectory.fit.cost - camera_only.fit.cost > kMostPull) return Miss::sensors_contradict;
  // By as much as the delay tells more than the bearings do.
  const double alone_mps = camera_only.at(motion.time_s).speed_std_mps;
  const double both_mps = joint.trajectory.at(motion.time_s).speed_std_mps;
  joint.trajectory.drift_std_mps =
      delay.drift_std_mps * std::max(0.0, 1.0 - std::pow(both_mps / alone_mps, 2));
  joint.power_chi2_per_block = delay.chi2_per_dof;
  joint.samples = delay.speed.samples_used;
  return joint;
}

}  // namespace vildar
