#pragma once

#include <vector>

#include <Eigen/Core>

#include "estimate/cubic_spline.h"
#include "estimate/delay_fit.h"
#include "estimate/path_model.h"

namespace vildar {

/// Unknowns of the delay model that are not coefficients of the curve. The curve is a function of
/// u = tau + alpha tau^2 / 2 + departed way / speed, the distance driven over the speed at the
/// reference time.
enum DelayParameter : int {
  kLogDelay,     ///< ln (baseline over speed)
  kAlpha,        ///< acceleration over speed, 1/s
  kLogFarGain,   ///< ln of the far gain over the near one
  kAngularGain,  ///< of the same, times the root of the relative power: mismatch with angle
  kNearAmbient,  ///< in power units
  kFarAmbient,
  kDelayParameters,
};

/// Blocks of both sides in power units, times from the reference.
struct DelayRows {
  struct Row {
    double tau_s, power, sigma, root;  ///< root: of the relative power above ambient
    bool far;
    double departed_m;  ///< way by which the known steps of acceleration depart from a constant one
  };
  std::vector<Row> rows;  ///< each side's in order of time, near first
  double unit_w = 1.0;
  double reference_s = 0.0;
  double first_s = 0.0, last_s = 0.0;   ///< of the rows, from the reference
  double last_far_s = 0.0;              ///< of the far rows
  std::vector<AccelerationStep> steps;  ///< from the reference, in m/s^2
};

/// Least squares of both pulses on one curve; priors included.
class DelayModel {
 public:
  DelayModel(const DelayProblem& problem, const DelayRows& rows, CubicSpline curve);

  struct Point {
    Eigen::VectorXd value;  ///< DelayParameter, then the curve's coefficients
    double cost = 0.0;      ///< half the sum of squares
    Eigen::MatrixXd information;
    Eigen::VectorXd gradient;
    bool converged = false;  ///< as minimise() leaves it
  };
  /// A first point: this delay, no acceleration, a flat curve.
  Eigen::VectorXd start(double delay_s) const;
  /// Levenberg-Marquardt over the free parameters; the delay too where `move_delay`.
  Point minimise(Eigen::VectorXd value, bool move_delay, int most_iterations) const;
  /// Residuals of the rows, whitened.
  Eigen::VectorXd residuals(const Eigen::VectorXd& value) const;
  std::vector<int> free(bool move_delay) const;
  /// Sum of squares by which gains and acceleration miss what was known of them, in sigmas.
  double prior_chi2(const Eigen::VectorXd& value) const;

 private:
  struct Light {
    CubicSpline::Local local;
    double by_log_delay = 0.0;  // of the way driven over the speed
    double gain = 1.0, light = 0.0, slope = 0.0;
  };
  Light light_of(const DelayRows::Row& row, const Eigen::VectorXd& value) const;
  bool drives_on(double alpha) const;
  Point at(const Eigen::VectorXd& value, bool with_derivatives) const;
  void add_priors(Point& point, bool with_derivatives) const;

  const DelayProblem& problem_;
  const DelayRows& rows_;
  CubicSpline curve_;
  std::array<double, 2> ambient_, ambient_std_;
};

}  // namespace vildar
