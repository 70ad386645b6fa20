#include "estimate/drawn.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/by_frame.h"
#include "core/median.h"
#include "estimate/line_fit.h"
#include "estimate/mixture.h"

namespace vildar {
namespace {

// Along the road, and across it.
Eigen::Vector2d place_m(const VehicleEstimate& vehicle, const TrackRow& row) {
  const double time_s = seconds_of(row.sighting.time);
  const Trajectory& likeliest = vehicle.trajectories.front();
  if (likeliest.problem.setting.bend == 0.0)
    return {*row.range_m, mixed_state(vehicle.trajectories, time_s).lateral_m};
  return {likeliest.along_m(time_s), likeliest.lateral_m()};
}

double light_of(const TrackRow& pair, double range_m) {
  return (pair.sighting.left->flux + pair.sighting.right->flux) * range_m * range_m;
}

}  // namespace

bool one_draws_the_other(const VehicleEstimate& one, const VehicleEstimate& other) {
  constexpr std::size_t kFewest = 15;
  constexpr double kLeast_s = 1.0, kTimesFarther = 1.33;
  // A car, and the gap behind it; a car with a drawbar, and a usual gap, where one is faint.
  constexpr double kShortest_m = 3.5, kGap_s = 0.25, kWithBar_m = 4.5, kUsual_s = 0.5;
  constexpr double kFaint = 0.6, kLongestBar_m = 8.0;
  constexpr double kNearest_m = 1.5, kBeside_m = 0.6, kRigid_m = 0.5;
  constexpr double kSigmas = 2.5, kScaleFloor = 0.01;
  const VehicleResult &a = one.result, &b = other.result;
  if (one.trajectories.empty() || other.trajectories.empty() || a.direction != b.direction)
    return false;
  std::vector<double> times_s, one_m, other_m, beside_m, speeds_mps, fainter;
  for_each_common_frame(
      one.rows, other.rows, [](const TrackRow& row) { return row.sighting.frame; },
      [&](const TrackRow& first, const TrackRow& second) {
        const auto shows_both = [](const TrackRow& row) {
          return row.sighting.left && row.sighting.right && row.range_m;
        };
        if (!shows_both(first) || !shows_both(second)) return;
        const double time_s = seconds_of(first.sighting.time);
        const Eigen::Vector2d a_m = place_m(one, first), b_m = place_m(other, second);
        times_s.push_back(time_s);
        one_m.push_back(a_m.x());
        other_m.push_back(b_m.x());
        beside_m.push_back(a_m.y() - b_m.y());
        const double brighter = light_of(first, a_m.x()) / light_of(second, b_m.x());
        fainter.push_back(std::min(brighter, 1.0 / brighter));
        speeds_mps.push_back(std::abs(mixed_state(one.trajectories, time_s).over_ground_mps));
      });
  if (times_s.size() < kFewest || times_s.back() - times_s.front() < kLeast_s) return false;
  const auto [nearest, farthest] = std::ranges::minmax(one_m);
  if (farthest < kTimesFarther * nearest || std::abs(median(std::move(beside_m))) > kBeside_m)
    return false;
  const auto line = fit_line(one_m, other_m);
  const auto* fit = std::get_if<LineFit>(&line);
  if (!fit) return false;
  const double scale_sigma = std::hypot(a.speed.std_mps / a.speed.speed_mps,
                                        b.speed.std_mps / b.speed.speed_mps, kScaleFloor);
  const double apart_m = std::abs(fit->intercept), usual_mps = median(std::move(speeds_mps));
  const double most_m = std::max(kShortest_m + kGap_s * usual_mps,
                                 median(std::move(fainter)) < kFaint
                                     ? std::min(kWithBar_m + kUsual_s * usual_mps, kLongestBar_m)
                                     : 0.0);
  return std::abs(fit->slope - 1.0) < kSigmas * scale_sigma && fit->residual_sigma < kRigid_m &&
         apart_m > kNearest_m && apart_m < most_m;
}

}  // namespace vildar
