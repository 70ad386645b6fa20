#include "estimate/power_model.h"

#include <array>
#include <cmath>

#include "estimate/vector_math.h"

namespace vildar {

std::string_view symbol_of(PowerParameter parameter) {
  constexpr std::array<std::string_view, kPowerParameters> kSymbols{"V",     "R", "K",  "d",
                                                                    "gamma", "a", "r_c"};
  return kSymbols[static_cast<std::size_t>(parameter)];
}

void PowerCurve::place(const PowerVector& p, const PowerSetting& setting,
                       std::span<const double> times_s) {
  const std::size_t n = times_s.size();
  for (auto* buffer : {&along_m_, &x_m_, &y_m_, &log_distance2_, &power_w_}) buffer->resize(n);
  const double speed = p[kPowerSpeed], range_m = p[kPowerRange], half = 0.5 * p[kPowerAcceleration];
  for (std::size_t i = 0; i < n; ++i)
    along_m_[i] = range_m - times_s[i] * (speed + half * times_s[i]);
  if (setting.curved) {
    const double radius_m = p[kPowerRadius];
    for (std::size_t i = 0; i < n; ++i) {
      const double arc_m = along_m_[i] - setting.straight_m;
      x_m_[i] = along_m_[i];
      y_m_[i] = p[kPowerPerpendicular];
      if (!(arc_m > 0.0)) continue;
      const double half_sine = std::sin(0.5 * arc_m / radius_m);
      x_m_[i] = setting.straight_m + radius_m * std::sin(arc_m / radius_m);
      y_m_[i] += 2.0 * radius_m * half_sine * half_sine;
    }
  } else {
    x_m_ = along_m_;
    std::fill(y_m_.begin(), y_m_.end(), p[kPowerPerpendicular]);
  }
  const double height2_m2 = setting.height_m * setting.height_m;
  for (std::size_t i = 0; i < n; ++i)
    log_distance2_[i] = x_m_[i] * x_m_[i] + y_m_[i] * y_m_[i] + height2_m2;
}

void PowerCurve::evaluate(const PowerVector& p, const PowerSetting& setting,
                          std::span<const double> times_s) {
  place(p, setting, times_s);
  const std::size_t n = times_s.size();
  const double m = setting.cosine_exponent;
  natural_logs(log_distance2_, log_distance2_);
  const double slope = -0.5 * (p[kPowerExponent] + m);
  for (std::size_t i = 0; i < n; ++i) power_w_[i] = p[kPowerLogGain] + slope * log_distance2_[i];
  if (m > 0.0) {
    log_x_.resize(n);
    for (std::size_t i = 0; i < n; ++i) log_x_[i] = x_m_[i] > 0.0 ? x_m_[i] : 1.0;
    natural_logs(log_x_, log_x_);
    for (std::size_t i = 0; i < n; ++i) power_w_[i] += m * log_x_[i];
  }
  exponentials(power_w_, power_w_);
  if (m > 0.0)
    for (std::size_t i = 0; i < n; ++i)
      if (!(x_m_[i] > 0.0)) power_w_[i] = 0.0;
}

void PowerCurve::differentiate(const PowerVector& p, const PowerSetting& setting,
                               std::span<const double> times_s,
                               std::span<const PowerParameter> wanted) {
  evaluate(p, setting, times_s);
  const std::size_t n = times_s.size();
  const double m = setting.cosine_exponent;
  const double steep = p[kPowerExponent] + m;
  const double height2_m2 = setting.height_m * setting.height_m;
  const double radius_m = p[kPowerRadius];
  for (auto* buffer : {&by_along_, &by_y_}) buffer->resize(n);
  by_radius_.assign(n, 0.0);
  // Powers times d ln P / dx and / dy, then along the path.
  for (std::size_t i = 0; i < n; ++i) {
    const double x = x_m_[i], y = y_m_[i];
    const double fall = steep * power_w_[i] / (x * x + y * y + height2_m2);
    by_along_[i] = -fall * x;
    by_y_[i] = -fall * y;
  }
  if (m > 0.0)  // the power is 0 behind the lamp
    for (std::size_t i = 0; i < n; ++i)
      by_along_[i] += m * power_w_[i] / (x_m_[i] > 0.0 ? x_m_[i] : 1.0);
  if (setting.curved)
    for (std::size_t i = 0; i < n; ++i) {
      const double arc_m = along_m_[i] - setting.straight_m;
      if (!(arc_m > 0.0)) continue;
      const double beta = arc_m / radius_m, sine = std::sin(beta), cosine = std::cos(beta);
      const double by_x = by_along_[i];
      by_along_[i] = by_x * cosine + by_y_[i] * sine;
      // At a fixed path length the arc angle falls as the radius grows.
      by_radius_[i] = by_x * (sine - beta * cosine) + by_y_[i] * (1.0 - cosine - beta * sine);
    }
  columns_.resize(wanted.size());
  for (std::size_t c = 0; c < wanted.size(); ++c) fill_column(wanted[c], times_s, columns_[c]);
}

void PowerCurve::fill_column(PowerParameter parameter, std::span<const double> times_s,
                             std::vector<double>& column) const {
  const std::size_t n = times_s.size();
  column.resize(n);
  switch (parameter) {
    case kPowerSpeed:
      for (std::size_t i = 0; i < n; ++i) column[i] = -times_s[i] * by_along_[i];
      break;
    case kPowerRange: column = by_along_; break;
    case kPowerLogGain: column = power_w_; break;
    case kPowerPerpendicular: column = by_y_; break;
    case kPowerExponent:
      for (std::size_t i = 0; i < n; ++i) column[i] = -0.5 * log_distance2_[i] * power_w_[i];
      break;
    case kPowerAcceleration:
      for (std::size_t i = 0; i < n; ++i) column[i] = -0.5 * times_s[i] * times_s[i] * by_along_[i];
      break;
    case kPowerRadius: column = by_radius_; break;
    case kPowerParameters: break;
  }
}

}  // namespace vildar
