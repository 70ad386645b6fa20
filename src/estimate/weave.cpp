#include "estimate/weave.h"

#include <algorithm>
#include <cmath>

#include "optics/ego_motion.h"

namespace vildar {

void let_weave(GeometryProblem& problem) {
  constexpr double kLeast_m = 0.002;
  if (problem.setting.bend == 0.0 || problem.lamps.empty()) return;
  const auto [first, last] = std::ranges::minmax(problem.lamps, {}, &LampObservation::time_s);
  if (!(first.time_s < last.time_s)) return;
  const HeadingSwings weave({first.time_s, last.time_s}, kWeavesAlike_s);
  for (int k = 0; k < kOwnSwings; ++k) {
    const double std_m = kWeave_m * std::sqrt(weave.variances()[k]);
    problem.ego_unknowns[static_cast<std::size_t>(kOwnSwing - kHeading + k)] = {
        0.0, std_m > kLeast_m ? std_m : 0.0};
  }
  for (std::size_t i = 0; i < problem.lamps.size(); ++i) {
    const HeadingSwings::Values left = weave.heading_at(problem.lamps[i].time_s);
    for (int k = 0; k < kOwnSwings; ++k)
      problem.ego[i].by_swing[static_cast<std::size_t>(k)].left_m = left[k];
  }
  problem.setting.weaves = true;
}

}  // namespace vildar
