#pragma once

#include <cmath>
#include <vector>

#include "core/outcome.h"
#include "estimate/delay_model.h"

namespace vildar {

/// The curve that both photodiodes' light follows, and the vehicle's motion, with a constant
/// acceleration.
struct DelayCurve {
  Eigen::VectorXd value;  ///< of DelayModel
  std::vector<double> breaks;
  struct Other {
    Eigen::VectorXd value;
    double more_chi2 = 0.0;
  };
  std::vector<Other> others;    ///< optima that explain the light less well
  double criterion = INFINITY;  ///< Akaike's

  int pieces() const { return static_cast<int>(breaks.size()) - 1; }
};

/// Breaks of the curve, closer where the light changes faster, but not so close that the blocks of
/// either side could follow it without regard to the other's.
std::vector<double> delay_breaks(const DelayRows& rows, double delay_s, int pieces);

/// Twice as many pieces as lower Akaike's criterion, the poor ones halved while it falls. Rows of
/// those that stay poor, where they are few, become as unsure as they scatter: what bends faster
/// than a block tells would be taken for motion.
Outcome<DelayCurve> best_delay_curve(const DelayProblem& problem, DelayRows& rows, double delay_s);

}  // namespace vildar
