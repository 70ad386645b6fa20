#include "estimate/curved_angle.h"

#include <cmath>
#include <stdexcept>
#include <vector>

#include "estimate/line_fit.h"

namespace vildar {
namespace {

double log_power(double half_angle_rad, const PowerLaw& law, double radius_m) {
  double value = std::log(law.gain_w) -
                 law.path_loss_exponent * std::log(2.0 * radius_m * std::sin(half_angle_rad));
  if (law.cosine_exponent > 0.0) value += law.cosine_exponent * std::log(std::cos(half_angle_rad));
  return value;
}

}  // namespace

double arc_angle_of_power(double power_w, const PowerLaw& law, Metres curve_radius) {
  const double radius_m = curve_radius.value();
  if (!(power_w > 0.0)) return kPi;
  if (!(law.cosine_exponent > 0.0)) {
    const double sine =
        std::pow(power_w / law.gain_w, -1.0 / law.path_loss_exponent) / (2.0 * radius_m);
    return sine < 1.0 ? 2.0 * std::asin(sine) : kPi;
  }
  // With the cosine there is no closed form: Newton in (ln beta, ln P), kept inside a bracket.
  const double target = std::log(power_w);
  double low_rad = 0.0, high_rad = 0.5 * kPi;
  double half_rad =
      std::atan(std::pow(power_w / law.gain_w, -1.0 / law.path_loss_exponent) / (2.0 * radius_m));
  for (int step = 0; step < 200; ++step) {
    const double error = log_power(half_rad, law, radius_m) - target;
    (error > 0.0 ? low_rad : high_rad) = half_rad;
    const double slope =
        -law.path_loss_exponent / std::tan(half_rad) - law.cosine_exponent * std::tan(half_rad);
    double next_rad = half_rad * std::exp(-error / (slope * half_rad));
    if (!(next_rad > low_rad && next_rad < high_rad)) next_rad = 0.5 * (low_rad + high_rad);
    if (std::abs(next_rad - half_rad) <= 1e-15 * half_rad) break;
    half_rad = next_rad;
  }
  return 2.0 * half_rad;
}

Outcome<CurvedAngleFit> fit_curved_angle(std::span<const double> time_s,
                                         std::span<const double> power_w, const PowerLaw& law,
                                         Metres curve_radius) {
  if (time_s.size() != power_w.size())
    throw std::invalid_argument("fit_curved_angle: as many times as powers are needed");
  if (!(law.gain_w > 0.0 && law.path_loss_exponent > 0.0 && curve_radius.value() > 0.0))
    throw std::domain_error("fit_curved_angle: K, gamma and the radius must be positive");
  if (time_s.size() < 3) return Miss::too_few_samples;

  std::vector<double> used_s, angle_rad;
  CurvedAngleFit fit;
  bool any_light = false;
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    if (!std::isfinite(power_w[i]) || !std::isfinite(time_s[i])) continue;
    any_light = any_light || power_w[i] > 0.0;
    used_s.push_back(time_s[i]);
    angle_rad.push_back(arc_angle_of_power(power_w[i], law, curve_radius));
    fit.samples_clamped += angle_rad.back() == kPi;
  }
  if (!any_light) return Miss::below_noise;
  const auto outcome = fit_line(used_s, angle_rad);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) return *miss;
  const LineFit& line = std::get<LineFit>(outcome);
  fit.angular_speed_rad_per_s = -line.slope;
  fit.speed_mps = -line.slope * curve_radius.value();
  fit.angle_at_zero_rad = line.intercept;
  fit.speed_sigma_mps = line.slope_sigma * curve_radius.value();
  fit.lag1_correlation = line.lag1_correlation;
  fit.samples_used = line.samples;
  fit.samples_outside = static_cast<std::int64_t>(time_s.size()) - line.samples;
  return fit;
}

}  // namespace vildar
