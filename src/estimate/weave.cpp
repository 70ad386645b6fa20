#include "estimate/weave.h"

#include <algorithm>
#include <cmath>

#include "optics/ego_motion.h"

namespace vildar {

bool weave_counts(const GeometryProblem& problem) {
  constexpr double kLow_m = 1.5;  // above the lamps
  const auto& drop_m = problem.priors.drop_m;
  return problem.setting.bend != 0.0 || !drop_m || drop_m->mean < kLow_m;
}

void let_weave(GeometryProblem& problem, double scale_m) {
  constexpr double kLeast_m = 0.002;
  if (problem.lamps.empty()) return;
  const auto [first, last] = std::ranges::minmax(problem.lamps, {}, &LampObservation::time_s);
  if (!(first.time_s < last.time_s)) return;
  const double by_m = problem.setting.bend != 0.0 ? 1.0 : scale_m;
  const HeadingSwings weave({first.time_s, last.time_s}, weaves_alike_s(problem.setting));
  for (int k = 0; k < kOwnSwings; ++k) {
    const double std_m = kWeave_m * std::sqrt(weave.variances()[k]);
    problem.ego_unknowns[static_cast<std::size_t>(kOwnSwing - kHeading + k)] = {
        0.0, std_m > kLeast_m ? std_m / by_m : 0.0};
  }
  for (std::size_t i = 0; i < problem.lamps.size(); ++i) {
    const HeadingSwings::Values left = weave.heading_at(problem.lamps[i].time_s);
    for (int k = 0; k < kOwnSwings; ++k)
      problem.ego[i].by_swing[static_cast<std::size_t>(k)].left_m = left[k];
  }
  problem.setting.weaves = true;
}

}  // namespace vildar
