#pragma once

#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace vildar {

/// What the received power of one passing vehicle depends on. Speed, range and acceleration hold at
/// the reference time.
enum PowerParameter : int {
  kPowerSpeed,          ///< V, m/s, positive: closing
  kPowerRange,          ///< R, m: path length to the sensor's cross-line; R_o + r_c beta on a curve
  kPowerLogGain,        ///< ln K, K in watts at 1 m (or in units of a camera's intensity)
  kPowerPerpendicular,  ///< d, m; on a curve d_o, positive to the side that the road bends to
  kPowerExponent,       ///< gamma
  kPowerAcceleration,   ///< m/s^2, positive: speeding up
  kPowerRadius,         ///< r_c, m, of the vehicle's own path; curved roads only
  kPowerParameters,
};
using PowerVector = Eigen::Matrix<double, kPowerParameters, 1>;
using PowerMatrix = Eigen::Matrix<double, kPowerParameters, kPowerParameters>;

/// The paper's letter: V, R, K, d, gamma, a, r_c.
std::string_view symbol_of(PowerParameter parameter);

/// What is not estimated. P = K D^-gamma cos^m(theta), cos(theta) = R / D, D^2 = x^2 + y^2 + h^2.
struct PowerSetting {
  double cosine_exponent = 0.0;  ///< m: 0 for the simulated channel, n + 1 for the Lambertian one
  bool curved = false;
  double straight_m = 0.0;  ///< R_o, curved roads only
  double height_m = 0.0;    ///< h: between sensor and lamps, where d does not already hold it
};

/// P(t) and its derivatives at many times, in buffers that later calls use again.
class PowerCurve {
 public:
  /// Powers at `times_s` after the reference time. Behind the lamp (x <= 0 with m > 0) power and
  /// derivatives are zero. Needs a positive distance at every time.
  void evaluate(const PowerVector& parameters, const PowerSetting& setting,
                std::span<const double> times_s);
  /// The same, and the columns dP/dp for each parameter of `wanted`.
  void differentiate(const PowerVector& parameters, const PowerSetting& setting,
                     std::span<const double> times_s, std::span<const PowerParameter> wanted);

  std::span<const double> power_w() const { return power_w_; }
  std::span<const double> column(std::size_t index) const { return columns_[index]; }

 private:
  void place(const PowerVector& parameters, const PowerSetting& setting,
             std::span<const double> times_s);
  void fill_column(PowerParameter parameter, std::span<const double> times_s,
                   std::vector<double>& column) const;

  std::vector<double> along_m_, x_m_, y_m_, log_distance2_, log_x_, power_w_;
  std::vector<double> by_along_, by_y_, by_radius_;  // dP / d(path), / d(y), / d(r_c)
  std::vector<std::vector<double>> columns_;
};

}  // namespace vildar
