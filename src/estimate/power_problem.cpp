#include "estimate/power_problem.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <Eigen/Eigenvalues>

namespace vildar {
namespace {

bool exact(const std::optional<Uncertain>& known) { return known && !(known->std > 0.0); }

// "A and B", "A, B and C".
std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  return text;
}

void check(const PowerProblem& problem) {
  if (problem.time_s.size() != problem.power_w.size())
    throw std::invalid_argument("power problem: as many times as powers are needed");
  const std::size_t sigmas = problem.sigma_w.size();
  if (sigmas > 1 && sigmas != problem.time_s.size())
    throw std::invalid_argument("power problem: one sigma, or one for each sample, is needed");
  for (const double sigma : problem.sigma_w)
    if (!(sigma > 0.0 && std::isfinite(sigma)))
      throw std::domain_error("power problem: sigmas must be positive");
  for (const PowerParameter p : {kPowerExponent, kPowerRadius})
    if (problem.known[p] && !(problem.known[p]->mean > 0.0))
      throw std::domain_error("power problem: " + std::string(symbol_of(p)) + " must be positive");
  for (const auto& known : problem.known)
    if (known && !(std::isfinite(known->mean) && std::isfinite(known->std) && known->std >= 0.0))
      throw std::domain_error("power problem: known values must be finite, their std not negative");
  if (!(problem.setting.cosine_exponent >= 0.0))
    throw std::domain_error("power problem: the cosine's exponent must not be negative");
}

}  // namespace

PowerKnowledge nothing_known() {
  PowerKnowledge known;
  known[kPowerAcceleration] = Uncertain{0.0, 0.0};
  return known;
}

double PowerEstimate::speed_sigma_mps() const {
  return std::sqrt(covariance(kPowerSpeed, kPowerSpeed));
}

std::array<double, 2> PowerEstimate::speed_95_mps(bool scale_uncertain) const {
  constexpr double kTwoSided = 1.959964;
  const double half = kTwoSided * speed_sigma_mps();
  if (!scale_uncertain || speed_mps() == 0.0) return {speed_mps() - half, speed_mps() + half};
  const double factor = std::exp(half / std::abs(speed_mps()));
  const double one = speed_mps() / factor, other = speed_mps() * factor;
  return {std::min(one, other), std::max(one, other)};
}

std::vector<PowerParameter> free_parameters(const PowerKnowledge& known,
                                            const PowerSetting& setting) {
  std::vector<PowerParameter> free;
  for (int p = 0; p < kPowerParameters; ++p)
    if (!exact(known[p]) && (p != kPowerRadius || setting.curved))
      free.push_back(static_cast<PowerParameter>(p));
  return free;
}

std::optional<PowerRefusal> scale_missing(const PowerKnowledge& known,
                                          const PowerSetting& setting) {
  if (known[kPowerLogGain] || known[kPowerSpeed] || known[kPowerRange]) return std::nullopt;
  if (setting.height_m > 0.0 || (setting.curved && setting.straight_m > 0.0)) return std::nullopt;
  // A length known to be exactly zero stays zero at every scale.
  const auto metric = [&](PowerParameter p) {
    return known[p] && !(exact(known[p]) && known[p]->mean == 0.0);
  };
  if (metric(kPowerPerpendicular) || (setting.curved && metric(kPowerRadius))) return std::nullopt;
  std::vector<std::string> unknown{"K"};
  if (!known[kPowerPerpendicular]) unknown.push_back("d");
  if (setting.curved) unknown.push_back("r_c");
  std::string reason = "speed is not observable: " + listed(unknown);
  reason += unknown.size() == 1   ? " unknown"
            : unknown.size() == 2 ? " both unknown"
                                  : " all unknown";
  if (known[kPowerPerpendicular]) reason += " and d = 0";
  return PowerRefusal{Miss::unobservable, reason};
}

std::variant<PowerSamples, PowerRefusal> gather(const PowerProblem& problem) {
  check(problem);
  if (auto refusal = scale_missing(problem.known, problem.setting)) return *refusal;
  PowerSamples samples;
  samples.noise_known = !problem.sigma_w.empty();
  const std::size_t n = problem.time_s.size();
  samples.time_s.reserve(n);
  samples.power_w.reserve(n);
  samples.weight.reserve(n);
  double first_s = 0.0, last_s = 0.0;
  bool any_light = false;
  for (std::size_t i = 0; i < n; ++i) {
    const double t_s = problem.time_s[i] - problem.reference_s, power = problem.power_w[i];
    if (!std::isfinite(t_s) || !std::isfinite(power)) continue;
    const double sigma = problem.sigma_w.empty()       ? 1.0
                         : problem.sigma_w.size() == 1 ? problem.sigma_w[0]
                                                       : problem.sigma_w[i];
    if (samples.time_s.empty()) first_s = last_s = t_s;
    first_s = std::min(first_s, t_s);
    last_s = std::max(last_s, t_s);
    any_light = any_light || power > 0.0;
    samples.time_s.push_back(t_s);
    samples.power_w.push_back(power);
    samples.weight.push_back(1.0 / (sigma * sigma));
  }
  samples.outside = static_cast<std::int64_t>(n - samples.time_s.size());
  // One more sample than unknowns; a prior counts for one.
  std::size_t unknowns = 0;
  for (const PowerParameter p : free_parameters(problem.known, problem.setting))
    unknowns += !problem.known[p];
  const std::size_t needed = unknowns + 1;
  if (samples.time_s.size() < std::max<std::size_t>(needed, 3))
    return PowerRefusal{Miss::too_few_samples,
                        std::to_string(samples.time_s.size()) + " usable samples, " +
                            std::to_string(std::max<std::size_t>(needed, 3)) + " needed"};
  const double widest_s = std::max(std::abs(first_s), std::abs(last_s));
  if (!(last_s - first_s > 1e-12 * (1.0 + widest_s)))
    return PowerRefusal{Miss::no_time_spread, "all samples bear the same time"};
  if (!any_light) return PowerRefusal{Miss::below_noise, "no sample has a positive power"};
  return samples;
}

std::variant<Eigen::MatrixXd, PowerRefusal> invert_information(
    const Eigen::MatrixXd& information, std::span<const PowerParameter> free) {
  constexpr double kSingular = 1e-13;  // of a matrix with unit diagonal
  const Eigen::Index n = information.rows();
  if (!information.allFinite() || !(information.diagonal().array() > 0.0).all()) {
    std::vector<std::string> unseen;
    for (Eigen::Index i = 0; i < n; ++i)
      if (!(information(i, i) > 0.0)) unseen.emplace_back(symbol_of(free[i]));
    return PowerRefusal{Miss::unobservable,
                        "speed is not observable: the samples do not depend on " + listed(unseen)};
  }
  const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * information * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled);
  if (!(solver.eigenvalues()[0] > kSingular)) {
    std::vector<std::string> mixed;
    for (Eigen::Index i = 0; i < n; ++i)
      if (std::abs(solver.eigenvectors()(i, 0)) > 0.1) mixed.emplace_back(symbol_of(free[i]));
    return PowerRefusal{Miss::unobservable, "speed is not observable: these samples cannot tell " +
                                                listed(mixed) + " apart"};
  }
  const Eigen::MatrixXd inverse = solver.eigenvectors() *
                                  solver.eigenvalues().cwiseInverse().asDiagonal() *
                                  solver.eigenvectors().transpose();
  return Eigen::MatrixXd(scale.asDiagonal() * inverse * scale.asDiagonal());
}

PowerMatrix spread_covariance(const Eigen::MatrixXd& covariance,
                              std::span<const PowerParameter> free) {
  PowerMatrix full = PowerMatrix::Zero();
  for (std::size_t i = 0; i < free.size(); ++i)
    for (std::size_t j = 0; j < free.size(); ++j) full(free[i], free[j]) = covariance(i, j);
  return full;
}

}  // namespace vildar
