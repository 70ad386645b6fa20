#include <cmath>

#include "estimate/curved_angle.h"
#include "estimate/power_estimators.h"
#include "estimate/power_inverse.h"
#include "estimate/power_slope.h"

namespace vildar {
namespace {

// The linear methods fit a line: speed and range alone.
std::optional<PowerRefusal> more_than_a_line(const PowerProblem& problem) {
  for (const PowerParameter p : free_parameters(problem.known, problem.setting))
    if (p != kPowerSpeed && p != kPowerRange)
      return PowerRefusal{Miss::unobservable, "a line fit gives V and R alone; " +
                                                  std::string(symbol_of(p)) +
                                                  " must be known exactly"};
  if (problem.known[kPowerSpeed] || problem.known[kPowerRange])
    return PowerRefusal{Miss::unobservable, "a line fit takes no priors on V or R"};
  if (problem.known[kPowerAcceleration]->mean != 0.0)
    return PowerRefusal{Miss::unobservable, "a line fit holds for constant speed alone"};
  return std::nullopt;
}

PowerVector known_values(const PowerProblem& problem) {
  PowerVector value = PowerVector::Zero();
  for (int p = 0; p < kPowerParameters; ++p)
    if (problem.known[p]) value[p] = problem.known[p]->mean;
  return value;
}

}  // namespace

PowerOutcome estimate_paper_ls(const PowerProblem& problem) {
  auto gathered = gather(problem);
  if (auto* refusal = std::get_if<PowerRefusal>(&gathered)) return *refusal;
  const PowerSamples& samples = std::get<PowerSamples>(gathered);
  if (auto refusal = more_than_a_line(problem)) return *refusal;
  PowerEstimate estimate;
  estimate.value = known_values(problem);
  const PowerLaw law{std::exp(estimate.value[kPowerLogGain]), estimate.value[kPowerExponent],
                     problem.setting.cosine_exponent};
  double scatter_m = 0.0, line_sigma_mps = 0.0;
  if (problem.setting.curved) {
    if (problem.setting.straight_m != 0.0 || problem.setting.height_m != 0.0 ||
        estimate.value[kPowerPerpendicular] != 0.0)
      return PowerRefusal{Miss::outside_model, "the paper's curved road has R_o = d_o = 0"};
    const double radius_m = estimate.value[kPowerRadius];
    const auto fit = fit_curved_angle(samples.time_s, samples.power_w, law, Metres(radius_m));
    if (const Miss* miss = std::get_if<Miss>(&fit))
      return PowerRefusal{*miss, "the curved-road angles give no line"};
    const auto& angle = std::get<CurvedAngleFit>(fit);
    estimate.value[kPowerSpeed] = angle.speed_mps;
    estimate.value[kPowerRange] = radius_m * angle.angle_at_zero_rad;
    line_sigma_mps = angle.speed_sigma_mps;
    estimate.samples_used = angle.samples_used;
    estimate.samples_outside = angle.samples_outside;
  } else {
    const Metres across(std::hypot(estimate.value[kPowerPerpendicular], problem.setting.height_m));
    const auto fit = fit_power_slope(samples.time_s, samples.power_w, law, across);
    if (const Miss* miss = std::get_if<Miss>(&fit))
      return PowerRefusal{*miss, *miss == Miss::outside_model
                                     ? "the power implies distances smaller than d"
                                     : "the implied ranges give no line"};
    const auto& slope = std::get<PowerSlopeFit>(fit);
    estimate.value[kPowerSpeed] = slope.speed_mps;
    estimate.value[kPowerRange] = slope.range_at_zero_m;
    line_sigma_mps = slope.speed_sigma_mps;
    estimate.samples_used = slope.samples_used;
    estimate.samples_outside = slope.samples_outside;
  }
  // Of the line's two coefficients, from its own scatter.
  double mean_s = 0.0, spread_s2 = 0.0;
  const auto n = static_cast<double>(samples.time_s.size());
  for (const double t : samples.time_s) mean_s += t / n;
  for (const double t : samples.time_s) spread_s2 += (t - mean_s) * (t - mean_s);
  scatter_m = line_sigma_mps * std::sqrt(spread_s2);
  const double variance = line_sigma_mps * line_sigma_mps;
  estimate.covariance(kPowerSpeed, kPowerSpeed) = variance;
  estimate.covariance(kPowerSpeed, kPowerRange) = mean_s * variance;
  estimate.covariance(kPowerRange, kPowerSpeed) = mean_s * variance;
  estimate.covariance(kPowerRange, kPowerRange) =
      scatter_m * scatter_m / n + mean_s * mean_s * variance;
  estimate.reference_s = problem.reference_s;
  estimate.samples_outside += samples.outside;
  estimate.chi2_per_dof = 1.0;
  return estimate;
}

PowerOutcome estimate_weighted_ls(const PowerProblem& problem) {
  constexpr int kRounds = 3;
  auto gathered = gather(problem);
  if (auto* refusal = std::get_if<PowerRefusal>(&gathered)) return *refusal;
  const PowerSamples& samples = std::get<PowerSamples>(gathered);
  if (auto refusal = more_than_a_line(problem)) return *refusal;
  PowerEstimate estimate;
  PowerVector value = known_values(problem);
  const std::size_t n = samples.time_s.size();
  const ImpliedPath path = implied_path(samples.power_w, value, problem.setting);
  std::vector<double> steepness = path.steepness;
  PowerCurve curve;
  const PowerParameter wanted[] = {kPowerRange};
  double chi2 = 0.0;
  // Weights from the noisy powers first, then from the fit itself.
  for (int round = 0; round <= kRounds; ++round) {
    double w = 0.0, wt = 0.0, wy = 0.0, wtt = 0.0, wty = 0.0;
    std::int64_t used = 0;
    for (std::size_t i = 0; i < n; ++i) {
      if (!path.inside[i]) continue;
      const double weight = samples.weight[i] * steepness[i] * steepness[i];
      w += weight;
      wt += weight * samples.time_s[i];
      wy += weight * path.along_m[i];
      ++used;
    }
    if (used < 3)
      return PowerRefusal{Miss::outside_model,
                          "fewer than three samples have a place on the law's outer branch"};
    for (std::size_t i = 0; i < n; ++i) {
      if (!path.inside[i]) continue;
      const double weight = samples.weight[i] * steepness[i] * steepness[i];
      const double dt = samples.time_s[i] - wt / w;
      wtt += weight * dt * dt;
      wty += weight * dt * (path.along_m[i] - wy / w);
    }
    if (!(wtt > 0.0)) return PowerRefusal{Miss::no_time_spread, "all usable samples bear one time"};
    const double mean_s = wt / w;
    value[kPowerSpeed] = -wty / wtt;
    value[kPowerRange] = wy / w + value[kPowerSpeed] * mean_s;
    chi2 = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      if (!path.inside[i]) continue;
      const double error =
          path.along_m[i] - value[kPowerRange] + value[kPowerSpeed] * samples.time_s[i];
      chi2 += samples.weight[i] * steepness[i] * steepness[i] * error * error;
    }
    const double degrees = static_cast<double>(used) - 2.0;
    const double scale = samples.noise_known ? 1.0 : chi2 / std::max(degrees, 1.0);
    estimate.covariance.setZero();
    estimate.covariance(kPowerSpeed, kPowerSpeed) = scale / wtt;
    estimate.covariance(kPowerSpeed, kPowerRange) = scale * mean_s / wtt;
    estimate.covariance(kPowerRange, kPowerSpeed) = scale * mean_s / wtt;
    estimate.covariance(kPowerRange, kPowerRange) = scale * (1.0 / w + mean_s * mean_s / wtt);
    estimate.chi2_per_dof = samples.noise_known && degrees > 0.0 ? chi2 / degrees : 1.0;
    estimate.noise_sigma_w =
        samples.noise_known ? 1.0 / std::sqrt(samples.weight[0]) : std::sqrt(scale);
    estimate.samples_used = used;
    estimate.iterations = round;
    curve.differentiate(value, problem.setting, samples.time_s, wanted);
    for (std::size_t i = 0; i < n; ++i) steepness[i] = std::abs(curve.column(0)[i]);
  }
  estimate.value = value;
  estimate.reference_s = problem.reference_s;
  estimate.samples_outside = samples.outside + static_cast<std::int64_t>(n) - estimate.samples_used;
  return estimate;
}

}  // namespace vildar
