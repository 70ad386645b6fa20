#include "estimate/power_filter.h"

#include <algorithm>
#include <cmath>

#include "estimate/power_estimators.h"

namespace vildar {

PowerFilter::PowerFilter(const PowerVector& value, const PowerMatrix& covariance,
                         const PowerSetting& setting)
    : value_(value), covariance_(covariance), setting_(setting) {
  for (int p = 0; p < kPowerParameters; ++p)
    if (covariance(p, p) > 0.0) free_.push_back(static_cast<PowerParameter>(p));
}

void PowerFilter::update(double time_s, double power_w, double sigma_w) {
  curve_.differentiate(value_, setting_, std::span(&time_s, 1), free_);
  PowerVector slope = PowerVector::Zero();
  for (std::size_t c = 0; c < free_.size(); ++c) slope[free_[c]] = curve_.column(c)[0];
  const PowerVector spread = covariance_ * slope;
  const double variance = slope.dot(spread) + sigma_w * sigma_w;
  const double innovation = power_w - curve_.power_w()[0];
  innovation_chi2_ += innovation * innovation / variance;
  value_ += spread * (innovation / variance);
  // Joseph's form keeps the covariance positive over many thousand samples.
  const PowerMatrix keep = PowerMatrix::Identity() - (spread / variance) * slope.transpose();
  covariance_ = keep * covariance_ * keep.transpose() +
                spread * spread.transpose() * (sigma_w * sigma_w / (variance * variance));
}

PowerOutcome estimate_kalman(const PowerProblem& problem) {
  // The filter linearises where it stands, so its first samples are fitted together, as many as it
  // takes for a speed that is roughly right; a wide prior keeps that fit sane.
  constexpr double kFirstShare = 0.2, kGrowth = 1.5, kRoughlyRight = 0.1;
  constexpr std::size_t kFirstLeast = 20;
  constexpr Uncertain kAnyVehicle{25.0, 10.0};
  auto gathered = gather(problem);
  if (auto* refusal = std::get_if<PowerRefusal>(&gathered)) return *refusal;
  const PowerSamples& samples = std::get<PowerSamples>(gathered);
  if (!samples.noise_known)
    return PowerRefusal{Miss::unobservable, "the filter needs the noise of a sample"};
  const std::size_t n = samples.time_s.size();
  std::size_t first = std::min(
      n, std::max(kFirstLeast, static_cast<std::size_t>(kFirstShare * static_cast<double>(n))));
  std::vector<double> sigma_w(n);
  for (std::size_t i = 0; i < n; ++i) sigma_w[i] = 1.0 / std::sqrt(samples.weight[i]);

  PowerProblem early = problem;
  early.reference_s = 0.0;
  if (!early.known[kPowerSpeed]) early.known[kPowerSpeed] = kAnyVehicle;
  PowerEstimate estimate;
  while (true) {
    early.time_s = std::span(samples.time_s).first(first);
    early.power_w = std::span(samples.power_w).first(first);
    early.sigma_w = std::span(sigma_w).first(first);
    const PowerOutcome start = estimate_max_likelihood(early);
    if (const auto* fitted = std::get_if<PowerEstimate>(&start)) {
      estimate = *fitted;
      if (first == n || estimate.speed_sigma_mps() < kRoughlyRight * std::abs(estimate.speed_mps()))
        break;
    } else if (first == n) {
      return start;
    }
    first = std::min(n, static_cast<std::size_t>(kGrowth * static_cast<double>(first)));
  }
  PowerFilter filter(estimate.value, estimate.covariance, problem.setting);
  for (std::size_t i = first; i < n; ++i)
    filter.update(samples.time_s[i], samples.power_w[i], sigma_w[i]);
  estimate.value = filter.value();
  estimate.covariance = filter.covariance();
  estimate.reference_s = problem.reference_s;
  estimate.samples_used = static_cast<std::int64_t>(n);
  estimate.samples_outside = samples.outside;
  const double chi2 = filter.innovation_chi2() + estimate.chi2_per_dof * static_cast<double>(first);
  estimate.chi2_per_dof = chi2 / static_cast<double>(n);
  estimate.stop = PowerStop::all_samples;
  return estimate;
}

}  // namespace vildar
