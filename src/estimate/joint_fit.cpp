#include "estimate/joint_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "estimate/joint_solve.h"

namespace vildar {
namespace {

// Chi-square per block if the model left out `unmodelled` of the light.
double chi2_per_block(const JointProblem& joint, const std::vector<Eigen::VectorXd>& errors,
                      double unmodelled) {
  double sum = 0.0, blocks = 0.0;
  for (std::size_t r = 0; r < errors.size(); ++r)
    for (std::size_t i = 0; i < joint.receivers[r].blocks.size(); ++i) {
      const LitBlock& block = joint.receivers[r].blocks[i];
      const double sigma = std::hypot(block.noise, unmodelled * block.light);
      sum += std::pow(errors[r][static_cast<Eigen::Index>(i)] / sigma, 2);
      blocks += 1.0;
    }
  return sum / blocks;
}

// Share of the light that gain and beam of the model leave out, as the errors show it: the first at
// which chi-square is what it should be, or the largest.
constexpr std::array<double, 8> kUnmodelled{0.001, 0.002, 0.003, 0.005, 0.0075, 0.01, 0.015, 0.02};
double unmodelled_share(const JointProblem& joint, const std::vector<Eigen::VectorXd>& errors) {
  constexpr double kEnough = 1.1;
  for (const double share : kUnmodelled)
    if (chi2_per_block(joint, errors, share) < kEnough) return share;
  return kUnmodelled.back();
}

// By how much the sigmas of a photodiode's blocks must grow for neighbours that err together.
double correlation_factor(const Lit& lit, const Eigen::VectorXd& errors, double unmodelled) {
  double product = 0.0, square = 0.0;
  Eigen::VectorXd whitened = errors;
  for (Eigen::Index i = 0; i < errors.size(); ++i) {
    const LitBlock& block = lit.blocks[static_cast<std::size_t>(i)];
    whitened[i] /= std::hypot(block.noise, unmodelled * block.light);
    square += whitened[i] * whitened[i];
    if (i > 0) product += whitened[i] * whitened[i - 1];
  }
  const auto n = static_cast<double>(errors.size());
  constexpr double kHighest = 0.95, kTaken = 6.0;  // unknowns that take slow errors with them
  const double lag = product / square + std::min(0.5, kTaken / n);
  if (!(lag > 2.0 / std::sqrt(n))) return 1.0;
  const double kept = std::min(lag, kHighest);
  return std::sqrt((1.0 + kept) / (1.0 - kept));
}

std::vector<PassGainRatio> gain_ratios(const JointProblem& joint, const JointSolution& solved) {
  std::vector<PassGainRatio> ratios;
  // Without the site's first photodiode the pass has them to another.
  if (joint.receivers.front().photodiode != 0) return ratios;
  for (std::size_t r = 0; r < joint.receivers.size(); ++r) {
    const Lit& lit = joint.receivers[r];
    const Eigen::Index at = first_own(r) + kLogRatio;
    if (!(solved.covariance(at, at) > 0.0)) continue;
    ratios.push_back({lit.photodiode, solved.unknowns.own[r][kLogRatio] - lit.receiver.log_ratio,
                      std::sqrt(solved.covariance(at, at)), lit.receiver.log_ratio_std});
  }
  return ratios;
}

// Why this solution is not to be used, if so.
std::optional<Miss> gate(const JointProblem& joint, const JointSolution& solved,
                         const Trajectory& camera_only) {
  constexpr double kWorstChi2 = 1.3;
  if (chi2_per_block(joint, solved.errors, kUnmodelled.back()) > kWorstChi2) return Miss::bad_fit;
  constexpr double kMostPull = 10.0;  // half a chi-square; the path has at most eleven unknowns
  const auto moved = geometry_cost(joint.geometry, solved.unknowns.path);
  if (!moved || *moved - camera_only.fit.cost > kMostPull) return Miss::sensors_contradict;
  return std::nullopt;
}

}  // namespace

Outcome<JointFit> fit_joint_from(const Trajectory& camera_only, const Site& site,
                                 std::span<const VehiclePower> power, double from_s, double to_s,
                                 double later_s) {
  Site from_later = site;
  for (PhotodiodeSite& diode : from_later.photodiodes) diode.time_offset_s.mean += later_s;
  JointProblem joint;
  if (const auto miss = prepare_joint(camera_only, from_later, power, from_s, to_s, joint))
    return *miss;
  joint.light.time_shift_s = -later_s;

  // First with the least trust in the light; then, if that holds, with as much as it deserves.
  std::vector<double> factors(joint.receivers.size(), 1.0);
  set_sigmas(joint, kUnmodelled.back(), factors);
  auto outcome = solve_joint(joint, start_of(joint, camera_only.fit.parameters));
  // All unknowns have priors or start from the bearings: a fit that runs away does not fit.
  if (std::holds_alternative<Miss>(outcome)) return Miss::bad_fit;
  JointSolution solved = std::get<JointSolution>(std::move(outcome));
  if (const auto miss = gate(joint, solved, camera_only)) return *miss;
  const double share = unmodelled_share(joint, solved.errors);
  for (std::size_t r = 0; r < factors.size(); ++r)
    factors[r] = correlation_factor(joint.receivers[r], solved.errors[r], share);
  set_sigmas(joint, share, factors);
  auto second = solve_joint(joint, solved.unknowns);
  JointSolution* sharper = std::get_if<JointSolution>(&second);
  if (sharper && !gate(joint, *sharper, camera_only)) solved = std::move(*sharper);

  JointFit fit;
  fit.gain_ratios = gain_ratios(joint, solved);
  fit.samples = joint.samples;
  fit.power_chi2_per_block = chi2_per_block(joint, solved.errors, kUnmodelled.back());
  fit.trajectory = camera_only;
  GeometryFit& path = fit.trajectory.fit;
  path.parameters = solved.unknowns.path;
  path.covariance = solved.covariance.topLeftCorner<kPathParameters, kPathParameters>();
  path.cost = *geometry_cost(joint.geometry, path.parameters);
  return fit;
}

Outcome<JointFit> fit_joint(const Trajectory& camera_only, const Site& site,
                            std::span<const VehiclePower> power, double from_s, double to_s) {
  constexpr double kStep_s = 0.25, kSigmas = 2.5, kFarthest_s = 3.0;
  auto found = fit_joint_from(camera_only, site, power, from_s, to_s, 0.0);
  const Miss* miss = std::get_if<Miss>(&found);
  if (!miss || (*miss != Miss::bad_fit && *miss != Miss::sensors_contradict)) return found;
  double std_s = 0.0;
  for (const PhotodiodeSite& diode : site.photodiodes)
    std_s = std::max(std_s, diode.time_offset_s.std);
  // A clock far off, as the site allows, is no small change of what the bearings say.
  double least_chi2 = INFINITY;
  const double farthest_s = std::min(kFarthest_s, kSigmas * std_s);
  for (double off_s = kStep_s; off_s <= farthest_s; off_s += kStep_s)
    for (const double later_s : {off_s, -off_s}) {
      auto other = fit_joint_from(camera_only, site, power, from_s, to_s, later_s);
      const JointFit* fit = std::get_if<JointFit>(&other);
      if (!fit || fit->power_chi2_per_block >= least_chi2) continue;
      least_chi2 = fit->power_chi2_per_block;
      found = std::move(other);
    }
  return found;
}

}  // namespace vildar
