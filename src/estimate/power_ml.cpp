#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "estimate/power_estimators.h"
#include "estimate/power_least_squares.h"
#include "estimate/power_start.h"

namespace vildar {
namespace {

constexpr int kMostIterations = 80;

// Noise from successive differences: the light of a vehicle changes slowly next to the sampling.
double difference_sigma(const std::vector<double>& power_w) {
  double sum = 0.0;
  for (std::size_t i = 1; i < power_w.size(); ++i)
    sum += (power_w[i] - power_w[i - 1]) * (power_w[i] - power_w[i - 1]);
  return std::sqrt(sum / (2.0 * static_cast<double>(power_w.size() - 1)));
}

double rms(std::span<const double> values, double degrees) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / degrees);
}

double median_sigma(std::span<const double> residuals) {
  constexpr double kNormal = 1.482602;
  std::vector<double> sizes(residuals.begin(), residuals.end());
  for (double& size : sizes) size = std::abs(size);
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return kNormal * *middle;
}

void set_sigma(PowerSamples& samples, double factor) {
  for (double& weight : samples.weight) weight /= factor * factor;
}

// Huber's estimate varies by E[psi^2] / E[psi']^2 times the plain one at the same information.
double huber_variance_factor(std::span<const double> residuals, double bound) {
  double psi2 = 0.0, inside = 0.0;
  for (const double r : residuals) {
    const double psi = std::clamp(r, -bound, bound);
    psi2 += psi * psi;
    inside += std::abs(r) < bound ? 1.0 : 0.0;
  }
  return psi2 * static_cast<double>(residuals.size()) / (inside * inside);
}

PowerOutcome fit(const PowerProblem& problem, double huber_sigma) {
  auto gathered = gather(problem);
  if (auto* refusal = std::get_if<PowerRefusal>(&gathered)) return *refusal;
  PowerSamples samples = std::get<PowerSamples>(std::move(gathered));
  const bool robust = std::isfinite(huber_sigma);
  if (!samples.noise_known) {
    const double sigma = difference_sigma(samples.power_w);
    const double largest = *std::max_element(samples.power_w.begin(), samples.power_w.end());
    set_sigma(samples, std::max(sigma, 1e-12 * largest));
  }
  auto start = power_start(samples, problem.known, problem.setting);
  if (auto* refusal = std::get_if<PowerRefusal>(&start)) return *refusal;

  PowerLeastSquares squares(samples, problem.known, problem.setting, huber_sigma);
  PowerLeastSquares::Minimum minimum{};
  minimum.value = std::get<PowerVector>(start);
  const auto& free = squares.free();
  double unknowns = 0.0, priors = 0.0;
  for (const PowerParameter p : free) (problem.known[p] ? priors : unknowns) += 1.0;
  const double degrees = static_cast<double>(samples.time_s.size()) - unknowns;
  int iterations = 0;
  // Blocks mislead where the light changes much within one; then single samples start better.
  constexpr double kBadFit = 2.0;  // chi-square per degree of freedom
  if (squares.cost_at(minimum.value).cost > 0.5 * kBadFit * degrees) {
    const auto other = power_start_by_samples(samples, problem.known, problem.setting);
    if (other && squares.cost_at(*other).cost < squares.cost_at(minimum.value).cost)
      minimum.value = *other;
  }
  // Where the noise is taken from the residuals, a second round uses what the first one left.
  for (int round = 0; round < (samples.noise_known ? 1 : 2); ++round) {
    if (round > 0) {
      squares.cost_at(minimum.value);
      const double factor =
          robust ? median_sigma(squares.residuals()) : rms(squares.residuals(), degrees);
      if (!(factor > 0.0)) break;
      set_sigma(samples, factor);
    }
    minimum = squares.minimise(minimum.value, kMostIterations);
    iterations += minimum.iterations;
  }
  const PowerCost at = squares.cost_at(minimum.value);
  auto inverse = invert_information(at.information, free);
  if (auto* refusal = std::get_if<PowerRefusal>(&inverse)) return *refusal;
  if (!minimum.converged)
    return PowerRefusal{Miss::not_converged,
                        "no minimum after " + std::to_string(iterations) + " iterations"};

  PowerEstimate estimate;
  estimate.value = minimum.value;
  Eigen::MatrixXd covariance = std::get<Eigen::MatrixXd>(std::move(inverse));
  if (robust) {
    // IRLS weights stand in the information; the plain one gives Huber's asymptotic covariance.
    PowerLeastSquares plain(samples, problem.known, problem.setting, kNoLoss);
    auto unweighted = invert_information(plain.cost_at(minimum.value).information, free);
    if (auto* refusal = std::get_if<PowerRefusal>(&unweighted)) return *refusal;
    covariance = std::get<Eigen::MatrixXd>(std::move(unweighted)) *
                 huber_variance_factor(squares.residuals(), huber_sigma);
  }
  estimate.covariance = spread_covariance(covariance, free);
  estimate.reference_s = problem.reference_s;
  estimate.samples_used = static_cast<std::int64_t>(samples.time_s.size());
  estimate.samples_outside = samples.outside;
  estimate.iterations = iterations;
  estimate.stop = PowerStop::converged;
  double sigma_sum = 0.0;
  for (const double weight : samples.weight) sigma_sum += 1.0 / std::sqrt(weight);
  estimate.noise_sigma_w = sigma_sum / static_cast<double>(samples.weight.size());
  // Degrees of freedom: samples and priors less everything that was fitted.
  estimate.chi2_per_dof = samples.noise_known ? 2.0 * at.cost / degrees : 1.0;
  if (!(estimate.speed_sigma_mps() < std::abs(estimate.speed_mps()) || problem.known[kPowerSpeed]))
    return PowerRefusal{Miss::too_uncertain,
                        "the samples leave the speed uncertain by more than its own size"};
  return estimate;
}

}  // namespace

PowerOutcome estimate_max_likelihood(const PowerProblem& problem) { return fit(problem, kNoLoss); }

PowerOutcome estimate_huber(const PowerProblem& problem) {
  constexpr double kBound = 1.345;
  return fit(problem, kBound);
}

PowerOutcome estimate_photodiode(std::span<const double> time_s, std::span<const double> power_w,
                                 std::span<const double> sigma_w, double reference_s,
                                 const PhotodiodeKnowledge& knowledge) {
  PowerProblem problem{time_s, power_w, sigma_w, {}, nothing_known(), reference_s};
  problem.setting.cosine_exponent = knowledge.cosine_exponent;
  problem.known[kPowerPerpendicular] = knowledge.perpendicular_m;
  problem.known[kPowerExponent] = knowledge.path_loss_exponent;
  if (knowledge.acceleration_mps2) problem.known[kPowerAcceleration] = knowledge.acceleration_mps2;
  if (knowledge.gain_w) {
    if (!(knowledge.gain_w->mean > 0.0))
      throw std::domain_error("estimate_photodiode: K must be positive");
    problem.known[kPowerLogGain] =
        Uncertain{std::log(knowledge.gain_w->mean), knowledge.gain_w->std / knowledge.gain_w->mean};
  }
  return estimate_max_likelihood(problem);
}

}  // namespace vildar
