#pragma once

#include <limits>

#include "estimate/power_problem.h"

namespace vildar {

/// How well parameters explain samples: half the (robust) sum of squares, its gradient and the
/// information matrix over the free parameters.
struct PowerCost {
  double cost = 0.0;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd information;
};

/// Plain squares: no residual is so large that it counts linearly.
inline constexpr double kNoLoss = std::numeric_limits<double>::infinity();

/// Least squares of whitened residuals and priors over the parameters that are not known exactly.
class PowerLeastSquares {
 public:
  /// `huber_sigma`: residuals beyond count linearly.
  PowerLeastSquares(const PowerSamples& samples, const PowerKnowledge& known,
                    const PowerSetting& setting, double huber_sigma);

  PowerCost cost_at(const PowerVector& value);

  struct Minimum {
    PowerVector value;
    PowerCost at;
    int iterations = 0;
    bool converged = false;
  };
  /// Gauss-Newton, damped (Levenberg, Marquardt) only where a plain step does not improve.
  Minimum minimise(const PowerVector& start, int most_iterations);

  /// Whitened residuals of the samples at the last cost_at().
  std::vector<double> residuals() const;
  const std::vector<PowerParameter>& free() const { return free_; }

 private:
  PowerVector moved(const PowerVector& value, const Eigen::VectorXd& step) const;

  const PowerSamples& samples_;
  PowerKnowledge known_;
  PowerSetting setting_;
  double huber_sigma_;
  std::vector<PowerParameter> free_;
  PowerCurve curve_;
  std::vector<double> pull_, weight_;  // pull: error times weight
};

}  // namespace vildar
