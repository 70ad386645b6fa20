#include "estimate/drawn.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/by_frame.h"
#include "core/median.h"
#include "estimate/line_fit.h"
#include "estimate/mixture.h"

namespace vildar {

bool one_draws_the_other(const VehicleEstimate& one, const VehicleEstimate& other) {
  constexpr std::size_t kFewest = 15;
  constexpr double kLeast_s = 1.0, kTimesFarther = 1.33;
  constexpr double kShortest_m = 3.5, kGap_s = 0.25;  // a car, and the gap behind it
  constexpr double kNearest_m = 1.5, kBeside_m = 0.6, kRigid_m = 0.5;
  constexpr double kSigmas = 2.5, kScaleFloor = 0.01;
  const VehicleResult &a = one.result, &b = other.result;
  if (one.trajectories.empty() || other.trajectories.empty() || a.direction != b.direction)
    return false;
  std::vector<double> times_s, one_m, other_m, beside_m, speeds_mps;
  for_each_common_frame(
      one.rows, other.rows, [](const TrackRow& row) { return row.sighting.frame; },
      [&](const TrackRow& first, const TrackRow& second) {
        const auto shows_both = [](const TrackRow& row) {
          return row.sighting.left && row.sighting.right && row.range_m;
        };
        if (!shows_both(first) || !shows_both(second)) return;
        const double time_s = seconds_of(first.sighting.time);
        times_s.push_back(time_s);
        one_m.push_back(*first.range_m);
        other_m.push_back(*second.range_m);
        const MotionState at = mixed_state(one.trajectories, time_s);
        beside_m.push_back(at.lateral_m - mixed_state(other.trajectories, time_s).lateral_m);
        speeds_mps.push_back(std::abs(at.over_ground_mps));
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
  const double apart_m = std::abs(fit->intercept);
  return std::abs(fit->slope - 1.0) < kSigmas * scale_sigma && fit->residual_sigma < kRigid_m &&
         apart_m > kNearest_m && apart_m < kShortest_m + kGap_s * median(std::move(speeds_mps));
}

}  // namespace vildar
