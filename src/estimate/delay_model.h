#pragma once

#include <array>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "estimate/cubic_spline.h"
#include "estimate/delay_fit.h"
#include "estimate/path_model.h"

namespace vildar {

/// Unknowns of the delay model that are neither coefficients of the curve nor steps of the
/// acceleration. The curve is a function of u = tau + alpha tau^2 / 2 + way of the steps / speed,
/// the distance driven over the speed at the reference time.
enum DelayParameter : int {
  kLogDelay,    ///< ln (baseline over speed)
  kAlpha,       ///< acceleration over speed, 1/s
  kLogFarGain,  ///< ln of the far gain over the near one
  kMismatch,    ///< in sigmas of DelayRows::Row::mismatch, so the next two of theirs
  kBend,
  kOrder,
  kNearAmbient,  ///< in power units
  kFarAmbient,
  kDelayParameters,
};

/// Light that both photodiodes receive more of, or less, from one time on, without delay: of
/// another lamp that comes on or goes out. A smooth step.
struct CommonLight {
  double tau_s = 0.0;    ///< its middle, from the reference
  double width_s = 1.0;  ///< on each side of it within which 84 % of the step lie

  /// How much of it is there at a time from the reference, 0 to 1.
  double share(double at_tau_s) const;
  /// From when on and until when that is not 0 or 1 to within 1e-17.
  std::pair<double, double> between_s() const {
    constexpr double kAll = 6.0;
    return {tau_s - kAll * width_s, tau_s + kAll * width_s};
  }
};

/// Blocks of both sides in power units, times from the reference.
struct DelayRows {
  struct Row {
    double tau_s, power, sigma, root;  ///< root: of the relative power above ambient
    bool far;
    /// Sigmas of how unlike the near one's light a far row's is (ln): by a straight line of the
    /// angle off the road, a parabola beside it, and another power of the axis' cosine.
    double mismatch = 0.0, bend = 0.0, order = 0.0;
    double doubt = 0.0;  ///< sigma of what else of it is unlike the near one's
  };
  std::vector<Row> rows;  ///< each side's in order of time, near first
  double unit_w = 1.0;
  double reference_s = 0.0;
  double first_s = 0.0, last_s = 0.0;  ///< of the rows, from the reference
  double last_far_s = 0.0;             ///< of the far rows
  double block_s = 0.0;                ///< over which a row is the mean
  std::vector<CommonLight> common;     ///< beside the vehicle's, of powers that are to be found
};

/// Least squares of both pulses on one curve. Priors are included but for that on the sizes of the
/// steps.
class DelayModel {
 public:
  /// `steps_s`: times from the reference at which the acceleration may change.
  DelayModel(const DelayProblem& problem, const DelayRows& rows, CubicSpline curve,
             std::vector<double> steps_s = {});

  struct Point {
    /// DelayParameter, the curve's coefficients, each common light's power on the near and on the
    /// far side, the steps' m/s^2.
    Eigen::VectorXd value;
    double cost = 0.0;  ///< half the sum of squares
    Eigen::MatrixXd information;
    Eigen::VectorXd gradient;
    Eigen::VectorXd doubt;   ///< change of the gradient by light as unlike as that
    bool converged = false;  ///< as minimise() leaves it
  };
  Point at(const Eigen::VectorXd& value, bool with_derivatives) const;
  /// A first point: this delay, no acceleration, a flat curve.
  Eigen::VectorXd start(double delay_s) const;
  /// Levenberg-Marquardt over the free parameters but for `held`; the delay too where `move_delay`.
  Point minimise(Eigen::VectorXd value, bool move_delay, int most_iterations,
                 const std::vector<int>& held = {}) const;
  /// Puts the curve and the ambient levels where the rest asks for them, in which all is linear;
  /// the cost there.
  double refit(Eigen::VectorXd& value) const;
  /// Where on the curve a row is read.
  double way_s(const DelayRows::Row& row, const Eigen::VectorXd& value) const;
  /// Residuals of the rows, whitened.
  Eigen::VectorXd residuals(const Eigen::VectorXd& value) const;
  std::vector<int> free(bool move_delay) const;
  /// Whether kMismatch, kBend and kOrder are free.
  bool finds_mismatch() const;
  /// Where the steps begin among the unknowns.
  int first_step() const { return first_common() + 2 * static_cast<int>(rows_.common.size()); }
  /// What a row is beyond its measured power, and the slopes of that by the unknowns.
  struct Term {
    int parameter;
    double slope;
  };
  struct Line {
    double beyond = 0.0, light = 0.0;
    std::vector<Term> terms;  ///< of one parameter each
  };
  /// By all unknowns, or by those alone in which all is linear: curve, ambient and common light.
  enum class Slopes { all, linear };
  void put_line(const DelayRows::Row& row, const Eigen::VectorXd& value, Line& line,
                Slopes slopes = Slopes::all) const;
  /// Of each common light, on the near and the far side.
  std::vector<std::array<double, 2>> common_powers(const Eigen::VectorXd& value) const;
  /// Their sum in a row.
  double common_light(const DelayRows::Row& row, const Eigen::VectorXd& value) const;
  /// Whether the vehicle never stands still or turns round, as a curve over its way demands.
  bool drives_on(const Eigen::VectorXd& value) const;
  struct Motion {
    double speed_mps = 0.0, acceleration_mps2 = 0.0;
    Eigen::VectorXd speed_slopes, acceleration_slopes;  ///< by all unknowns
  };
  Motion motion_at(const Eigen::VectorXd& value, double tau_s) const;
  /// A row's light, without ambient, and how it grows by each second of way at the reference speed.
  struct Brightness {
    double light = 0.0, per_way_s = 0.0;
  };
  Brightness brightness_of(const DelayRows::Row& row, const Eigen::VectorXd& value) const {
    const Light found = light_of(row, value);
    return {found.light, found.slope};
  }

 private:
  struct Light {
    CubicSpline::Local local;
    double by_log_delay = 0.0;  // of the way driven over the speed
    double gain = 1.0, light = 0.0, slope = 0.0;
  };
  int first_common() const { return kDelayParameters + curve_.size(); }
  double by_log_delay(const DelayRows::Row& row, const Eigen::VectorXd& value) const;
  /// Of the ambient and of common light.
  double other_light(const DelayRows::Row& row, const Eigen::VectorXd& value) const;
  Light light_of(const DelayRows::Row& row, const Eigen::VectorXd& value) const;
  Point about(const Eigen::VectorXd& value, Slopes slopes) const;
  void add_rows(Point& point, Slopes slopes) const;
  void add_priors(Point& point, bool with_derivatives) const;

  const DelayProblem& problem_;
  const DelayRows& rows_;
  CubicSpline curve_;
  std::vector<AccelerationStep> steps_;  // of unit size
  std::array<double, 2> ambient_, ambient_std_;
};

}  // namespace vildar
