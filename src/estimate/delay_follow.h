#pragma once

#include <vector>

#include "estimate/delay_curve.h"
#include "estimate/delay_motion.h"

namespace vildar {

/// The light as one curve on both sides beside what comes and goes at once, and how the vehicle
/// moved.
struct Followed {
  DelayRows rows;     ///< with the common light, and sigmas that grew where the curve is too stiff
  DelayCurve steady;  ///< with a constant acceleration
  std::vector<double> steps_s;
  DelayMotion motion;
  double common_doubt = 0.0;  ///< relative sigma of the speed: the common light may be none

  DelayModel steady_model(const DelayProblem& problem) const {
    return {problem, rows, CubicSpline(steady.breaks)};
  }
  DelayModel model(const DelayProblem& problem) const {
    return {problem, rows, CubicSpline(steady.breaks), steps_s};
  }
};

/// Takes in light that both photodiodes receive at once where up to four steps of it explain what
/// is not the vehicle's own; where they do not, the vehicle's alone.
/// Misses: those of best_delay_curve(), below_noise, not_converged, outside_model (what comes and
/// goes at once is brighter than the vehicle, or comes on one side as it goes on the other).
Outcome<Followed> follow(const DelayProblem& problem, const DelayRows& rows, double delay_s);

/// Whether chi-square is more than this by where both photodiodes see light at once, above levels
/// of any size: the same, as of the dawn or of clouds, or as much more or less as goes with it
/// best, as of lamps nearer to one, or in turn nearer to either. Beside common light, if there is
/// some, and three steps more of it.
bool told_from_no_delay(const DelayProblem& problem, const Followed& found, double chi2);

}  // namespace vildar
