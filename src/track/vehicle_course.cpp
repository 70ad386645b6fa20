#include "track/vehicle_course.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "core/median.h"

namespace vildar {
namespace {

// Of the place of a lamp: its row wanders on wet roads, where its image clips together with it.
const Eigen::Array2d kSigma_px(1.0, 3.0);
// Errors of neighbouring frames are alike.
constexpr double kFramesAlike = 4.0;

double mean_time_s(std::span<const LampLook> looks) {
  double sum_s = 0.0;
  for (const LampLook& look : looks) sum_s += look.time_s;
  return sum_s / static_cast<double>(looks.size());
}

}  // namespace

std::optional<RoadPosition> place_of(const LampLook& look, const RoadView& view) {
  if (!look.left_px || !look.right_px) {
    const Eigen::Vector2d at_px = look.left_px ? *look.left_px : *look.right_px;
    return view.road_at(at_px, view.place(at_px).inverse_depth_per_m);
  }
  const PairFit fit = view.fit_pair(*look.left_px, *look.right_px, 1.0);
  if (!std::isfinite(fit.chi2)) return std::nullopt;
  return view.road_at(0.5 * (*look.left_px + *look.right_px), fit.inverse_depth_per_m);
}

std::vector<LampLook> looks_of(const std::vector<LampRecord>& left,
                               const std::vector<LampRecord>& right) {
  std::vector<LampLook> looks;
  for (auto one = left.begin(), other = right.begin(); one != left.end() || other != right.end();) {
    const bool on_left = one != left.end() && (other == right.end() || one->frame <= other->frame);
    const bool on_right = other != right.end() && (one == left.end() || other->frame <= one->frame);
    LampLook look{seconds_of((on_left ? one : other)->time), std::nullopt, std::nullopt};
    if (on_left && one->merged_px == 0.0) look.left_px = one->at_px;
    if (on_right && other->merged_px == 0.0) look.right_px = other->at_px;
    if (look.left_px || look.right_px) looks.push_back(look);
    one += on_left;
    other += on_right;
  }
  return looks;
}

std::optional<VehicleCourse> VehicleCourse::fit(std::span<const LampLook> looks, double time_s,
                                                const State& prior,
                                                const Information& prior_information,
                                                const RoadView& view) {
  constexpr int kRounds = 12;
  constexpr double kWidest = 8.0, kNarrowing = 0.7, kCauchy = 2.4;  // sigmas
  const State step(0.1, 0.1, 0.02, 0.02), longest(5.0, 5.0, 0.5, 0.2);
  State state = prior;
  Information information;
  double misfit = 0.0, weights = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    const double scale = std::max(kCauchy, kWidest * std::pow(kNarrowing, round));
    information = prior_information;
    State gradient = prior_information * (prior - state);
    misfit = weights = 0.0;
    for (const LampLook& look : looks) {
      const auto spot_px = [&](const State& s, double side) {
        return view.spot_at({s[kAlong] + s[kSpeed] * (look.time_s - time_s),
                             s[kLateral] + 0.5 * side * s[kSeparation]});
      };
      for (const double side : {1.0, -1.0}) {
        const auto& seen_px = side > 0.0 ? look.left_px : look.right_px;
        if (!seen_px) continue;
        const auto here_px = spot_px(state, side);
        if (!here_px) return std::nullopt;
        Eigen::Matrix<double, 2, kStates> slope;
        for (int i = 0; i < kStates; ++i) {
          State moved = state;
          moved[i] += step[i];
          const auto there_px = spot_px(moved, side);
          if (!there_px) return std::nullopt;
          slope.col(i) = (*there_px - *here_px) / step[i];
        }
        slope.array().colwise() /= kSigma_px;
        const Eigen::Vector2d off = (*seen_px - *here_px).array() / kSigma_px;
        const double weight = 1.0 / (1.0 + off.squaredNorm() / (scale * scale));
        information += weight * slope.transpose() * slope;
        gradient += weight * slope.transpose() * off;
        misfit += weight * off.squaredNorm();
        weights += 2.0 * weight;
      }
    }
    const State change = information.ldlt().solve(gradient);
    if (!change.allFinite()) return std::nullopt;
    state += change.cwiseMax(-longest).cwiseMin(longest);
  }
  VehicleCourse course;
  course.time_s_ = time_s;
  course.state_ = state;
  course.covariance_ =
      information.inverse() * kFramesAlike * std::max(1.0, misfit / std::max(1.0, weights));
  return course;
}

std::optional<VehicleCourse> VehicleCourse::of(std::span<const LampLook> looks,
                                               const RoadView& view) {
  constexpr std::ptrdiff_t kFewest = 8, kFewestBoth = 4;
  constexpr double kSeparationShare = 0.2, kNoSeparation_m = 0.01;
  const auto both = [](const LampLook& look) { return look.left_px && look.right_px; };
  const auto pairs = std::ranges::count_if(looks, both);
  const bool alone = pairs == 0;
  if (std::ssize(looks) < kFewest || (!alone && pairs < kFewestBoth)) return std::nullopt;

  // First a line through what separation and elevation say, by medians (Theil 1950, Sen 1968).
  const double time_s = mean_time_s(looks);
  std::vector<double> times_s, alongs_m, speeds_mps, starts_m, laterals_m;
  for (const LampLook& look : looks) {
    if (!alone && !both(look)) continue;
    const auto at = place_of(look, view);
    if (!at) continue;
    for (std::size_t i = 0; i < times_s.size(); ++i)
      speeds_mps.push_back((at->along_m - alongs_m[i]) / (look.time_s - time_s - times_s[i]));
    times_s.push_back(look.time_s - time_s);
    alongs_m.push_back(at->along_m);
    laterals_m.push_back(at->lateral_m);
  }
  if (speeds_mps.empty()) return std::nullopt;
  const double speed_mps = median(std::move(speeds_mps));
  for (std::size_t i = 0; i < times_s.size(); ++i)
    starts_m.push_back(alongs_m[i] - speed_mps * times_s[i]);
  const State start(median(std::move(starts_m)), speed_mps, median(std::move(laterals_m)),
                    alone ? 0.0 : view.separation_m());
  Information prior_information = Information::Zero();
  prior_information(kSeparation, kSeparation) =
      std::pow(alone ? kNoSeparation_m : kSeparationShare * view.separation_m(), -2);
  return fit(looks, time_s, start, prior_information, view);
}

std::optional<VehicleCourse> VehicleCourse::placed(std::span<const LampLook> looks,
                                                   const RoadView& view) const {
  constexpr double kKeptLateral_m = 1.0;
  const double time_s = mean_time_s(looks);
  State start = state_;
  start[kAlong] = along_m(time_s);
  Information prior_information = Information::Zero();
  prior_information(kLateral, kLateral) = std::pow(kKeptLateral_m, -2);
  prior_information(kSpeed, kSpeed) = 1.0 / covariance_(kSpeed, kSpeed);
  prior_information(kSeparation, kSeparation) = 1.0 / covariance_(kSeparation, kSeparation);
  return fit(looks, time_s, start, prior_information, view);
}

double VehicleCourse::along_m(double time_s) const {
  return state_[kAlong] + state_[kSpeed] * (time_s - time_s_);
}

double VehicleCourse::along_sigma_m(double time_s) const {
  const double off_s = time_s - time_s_;
  return std::sqrt(std::max(0.0, covariance_(kAlong, kAlong) +
                                     2.0 * off_s * covariance_(kAlong, kSpeed) +
                                     off_s * off_s * covariance_(kSpeed, kSpeed)));
}

}  // namespace vildar
