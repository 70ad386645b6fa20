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
  columns_.resize(wanted.size());
  for (auto& column : columns_) column.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double power = power_w_[i], x = x_m_[i], y = y_m_[i], t = times_s[i];
    const double distance2 = x * x + y * y + height2_m2;
    // d ln P / dx and / dy, then along the path.
    const double by_x = -steep * x / distance2 + (m > 0.0 && x > 0.0 ? m / x : 0.0);
    const double by_y = -steep * y / distance2;
    double by_along = by_x, by_radius = 0.0;
    const double arc_m = along_m_[i] - setting.straight_m;
    if (setting.curved && arc_m > 0.0) {
      const double beta = arc_m / radius_m, sine = std::sin(beta), cosine = std::cos(beta);
      by_along = by_x * cosine + by_y * sine;
      // At a fixed path length the arc angle falls as the radius grows.
      by_radius = by_x * (sine - beta * cosine) + by_y * (1.0 - cosine - beta * sine);
    }
    for (std::size_t c = 0; c < wanted.size(); ++c) {
      double by = 0.0;
      switch (wanted[c]) {
        case kPowerSpeed: by = -t * by_along; break;
        case kPowerRange: by = by_along; break;
        case kPowerLogGain: by = 1.0; break;
        case kPowerPerpendicular: by = by_y; break;
        case kPowerExponent: by = -0.5 * log_distance2_[i]; break;
        case kPowerAcceleration: by = -0.5 * t * t * by_along; break;
        case kPowerRadius: by = by_radius; break;
        case kPowerParameters: break;
      }
      columns_[c][i] = power * by;
    }
  }
}

}  // namespace vildar
