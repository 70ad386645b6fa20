#include "estimate/trajectory.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <ceres/jet.h>

namespace vildar {
namespace {

template <int kBy>
PathVector slopes_of(const ceres::Jet<double, kBy>& value) {
  PathVector slopes = PathVector::Zero();
  slopes.head<kBy>() = value.v;
  return slopes;
}

// What a time needs of each step.
template <class Of>
Eigen::VectorXd by_steps(const Trajectory& trajectory, Of of) {
  const std::vector<AccelerationStep>& steps = trajectory.problem.setting.steps;
  Eigen::VectorXd values(static_cast<Eigen::Index>(steps.size()));
  for (std::size_t k = 0; k < steps.size(); ++k)
    values[static_cast<Eigen::Index>(k)] = steps[k].along == Along::road ? of(steps[k]) : 0.0;
  return values;
}

/// By how much the middle of a vehicle that was seen on the arc may drive faster or slower than its
/// one lamp that is seen, the inner or the outer one of a pair.
double turns_wider_mps(const Trajectory& one, double over_ground_mps) {
  const GeometryProblem& problem = one.problem;
  const PathSetting& setting = problem.setting;
  if (problem.pairs || setting.bend == 0.0) return 0.0;
  const PathVector& p = one.fit.parameters;
  const double scale_m = std::exp(p[kLogScale]);
  if (std::max(one.along_m(one.from_s), one.along_m(one.to_s)) < bend_begins_m(p.data(), setting))
    return 0.0;
  const double off_middle_m =
      problem.priors.separation_m ? 0.5 * problem.priors.separation_m->mean : kHalfPair_m;
  const double radius_m = scale_m * std::exp(p[kLogRadius]) * lane_way_share(p.data(), setting);
  return off_middle_m / radius_m * over_ground_mps;
}

// With slopes by the first `kBy` parameters.
template <int kBy>
MotionState state_of(const Trajectory& one, double time_s) {
  const GeometryProblem& problem = one.problem;
  const PathVector& parameters = one.fit.parameters;
  using Jet = ceres::Jet<double, kBy>;
  std::array<Jet, kPathParameters> p;
  for (int i = 0; i < kPathParameters; ++i)
    p[static_cast<std::size_t>(i)] = i < kBy ? Jet(parameters[i], i) : Jet(parameters[i]);
  const double tau_s = time_s - problem.reference_s;
  const auto place = lamp_from_camera_m(p.data(), problem.setting, tau_s, 0.0,
                                        one.ego.deviation(problem.reference_s, time_s));
  const Jet scale_m = exp(p[kLogScale]);
  const Jet lane_share = lane_way_share(p.data(), problem.setting);
  const Jet over_ground = scale_m * (p[kClosingRate] + tau_s * p[kAcceleration] +
                                     problem.setting.departed_rate(tau_s)) -
                          lane_share * one.ego.speed_mps(problem.reference_s);
  MotionState state;
  state.range_m = place.x().a + problem.setting.camera_m.x();
  state.range_std_m =
      one.std_of(slopes_of(place.x()),
                 -scale_m.a * by_steps(one, [&](const auto& step) { return step.way(tau_s); }));
  state.lateral_m = place.y().a + problem.setting.camera_m.y();
  state.over_ground_mps = over_ground.a;
  state.speed_std_mps = std::hypot(
      std::hypot(
          one.std_of(slopes_of(over_ground),
                     scale_m.a * by_steps(one, [&](const auto& step) { return step.rate(tau_s); })),
          one.drift_std_mps),
      one.ego.speed_std_mps(), turns_wider_mps(one, over_ground.a));
  state.scaled_mps = over_ground.a + lane_share.a * one.ego.speed_mps(problem.reference_s);
  state.closing_mps = over_ground.a + lane_share.a * one.ego.speed_mps(time_s);
  const double rate_mps2 =
      scale_m.a * (parameters[kAcceleration] + problem.setting.departed_acceleration(tau_s));
  state.acceleration_mps2 = over_ground.a < 0.0 ? -rate_mps2 : rate_mps2;
  return state;
}

}  // namespace

MotionState Trajectory::at(double time_s) const {
  // The pose bears on what is seen alone.
  return problem.setting.ego_unsure ? state_of<kPathParameters>(*this, time_s)
                                    : state_of<kYaw>(*this, time_s);
}

double Trajectory::lamp_height_m() const {
  return problem.setting.camera_m.z() - std::exp(fit.parameters[kLogScale]) * fit.parameters[kDrop];
}

double Trajectory::common_std_mps(double time_s) const {
  return std::hypot(ego.stated_std_mps(), turns_wider_mps(*this, at(time_s).over_ground_mps));
}

double Trajectory::lateral_m() const {
  return problem.setting.camera_m.y() +
         std::exp(fit.parameters[kLogScale]) * fit.parameters[kLateral];
}

double Trajectory::crossed_m() const {
  constexpr int kLooks = 20;
  if (!problem.setting.crosses()) return 0.0;
  double left = 0.0, right = 0.0;
  for (int i = 0; i <= kLooks; ++i) {
    const double time_s = from_s + (to_s - from_s) * i / kLooks;
    const double aside = problem.setting.departed(time_s - problem.reference_s, Along::across);
    left = std::max(left, aside);
    right = std::min(right, aside);
  }
  return std::exp(fit.parameters[kLogScale]) * (left - right);
}

double Trajectory::along_m(double time_s) const {
  const PathSetting& setting = problem.setting;
  const PathVector& p = fit.parameters;
  const double tau_s = time_s - problem.reference_s;
  return setting.camera_m.x() +
         std::exp(p[kLogScale]) *
             (1.0 - tau_s * (p[kClosingRate] + 0.5 * tau_s * p[kAcceleration]) -
              setting.departed(tau_s));
}

double Trajectory::std_of(const PathVector& by_path, const Eigen::VectorXd& by_step) const {
  return std::sqrt(
      std::max(0.0, by_path.dot(fit.covariance * by_path) + change.variance(by_path, by_step)));
}

double Trajectory::scale_std() const { return std::sqrt(fit.covariance(kLogScale, kLogScale)); }

SpeedEstimate speed_estimate(const MotionState& state, double time_s, bool moving_camera,
                             std::int64_t samples) {
  constexpr double kTwoSided95 = 1.959963984540054;
  constexpr double kLogNormalLimit = 0.3;
  SpeedEstimate estimate;
  estimate.time_s = time_s;
  estimate.speed_mps = std::abs(state.over_ground_mps);
  estimate.std_mps = state.speed_std_mps;
  estimate.samples_used = samples;
  const double log_std = estimate.std_mps / estimate.speed_mps;
  if (!moving_camera && log_std < kLogNormalLimit) {
    estimate.lo95_mps = estimate.speed_mps * std::exp(-kTwoSided95 * log_std);
    estimate.hi95_mps = estimate.speed_mps * std::exp(kTwoSided95 * log_std);
  } else {
    estimate.lo95_mps = std::max(0.0, estimate.speed_mps - kTwoSided95 * estimate.std_mps);
    estimate.hi95_mps = estimate.speed_mps + kTwoSided95 * estimate.std_mps;
  }
  return estimate;
}

double best_time_s(const Trajectory& trajectory, double from_s, double to_s) {
  // The common scale is the same share of every speed, so what differs is the shape: the smallest
  // absolute sigma of speed over scale.
  constexpr int kSteps = 32;
  constexpr double kDrives = 0.3;  // of its highest speed: one that stops is asked for before
  const auto time_at = [&](int i) { return from_s + (to_s - from_s) * i / kSteps; };
  constexpr double kSure = 0.3;  // one sigma: what is less sure sets no highest speed
  std::array<double, kSteps + 1> speeds_mps{};
  double highest_mps = 0.0;
  for (int i = 0; i <= kSteps; ++i) {
    const MotionState state = trajectory.at(time_at(i));
    const auto at = static_cast<std::size_t>(i);
    speeds_mps[at] = std::abs(state.over_ground_mps);
    if (state.speed_std_mps < kSure * speeds_mps[at])
      highest_mps = std::max(highest_mps, speeds_mps[at]);
  }
  double best_s = 0.5 * (from_s + to_s), least = INFINITY;
  const PathMatrix& covariance = trajectory.fit.covariance;
  for (int i = 0; i <= kSteps; ++i) {
    if (speeds_mps[static_cast<std::size_t>(i)] < kDrives * highest_mps) continue;
    const double time_s = time_at(i);
    const double tau_s = time_s - trajectory.problem.reference_s;
    PathVector rate = PathVector::Zero();
    rate[kClosingRate] = 1.0;
    rate[kAcceleration] = tau_s;
    const double variance =
        rate.dot(covariance * rate) +
        trajectory.change.variance(
            rate, by_steps(trajectory, [&](const auto& step) { return step.rate(tau_s); }));
    if (variance < least) {
      least = variance;
      best_s = time_s;
    }
  }
  return best_s;
}

}  // namespace vildar
