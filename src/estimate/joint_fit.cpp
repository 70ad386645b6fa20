#include "estimate/joint_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <ceres/ceres.h>

#include "estimate/joint_problem.h"
#include "estimate/solve.h"

namespace vildar {
namespace {

constexpr double kHuberBound_1d = 2.0;
// Of the cost. The beam's coefficients creep long after everything else stands.
constexpr double kTolerance = 1e-5;

struct LightPrior {
  const LightSetting* setting;

  template <class T>
  bool operator()(const T* path, const T* light, T* residual) const {
    const auto& s = *setting;
    residual[0] =
        s.log_gain_std > 0.0
            ? (light[kLogGain] + light[kExponent] * path[kLogScale] - s.log_gain) / s.log_gain_std
            : T(0.0);
    residual[1] = s.exponent_std > 0.0 ? (light[kExponent] - s.exponent) / s.exponent_std : T(0.0);
    residual[2] = s.time_shift_std_s > 0.0 ? light[kTimeShift] / s.time_shift_std_s : T(0.0);
    for (int i = kBeamWidth; i < kLightParameters; ++i)
      residual[3 + i - kBeamWidth] = light[i] / beam_prior_std(i);
    return true;
  }
};
constexpr int kLightPriors = 5 + kBeamWaves;

struct ReceiverPrior {
  const Receiver* receiver;
  double background;
  double span_s;

  template <class T>
  bool operator()(const T* own, T* residual) const {
    residual[0] = own[kBackground] - background;  // up to the brightest signal
    residual[1] = own[kDrift] * span_s;
    residual[2] = receiver->log_ratio_std > 0.0
                      ? (own[kLogRatio] - receiver->log_ratio) / receiver->log_ratio_std
                      : T(0.0);
    residual[3] = receiver->ahead_std_m > 0.0 ? own[kAhead] / receiver->ahead_std_m : T(0.0);
    return true;
  }
};
constexpr int kReceiverPriors = 4;

struct Unknowns {
  PathVector path;
  LightVector light{};
  std::vector<ReceiverVector> own;
};

struct Solved {
  GeometryFit fit;
  Eigen::MatrixXd covariance;  ///< of all free unknowns: path, light, each photodiode's own
  std::vector<Eigen::VectorXd> errors;  ///< of each photodiode's blocks, in power units
};

std::vector<int> free_light(const LightSetting& light) {
  std::vector<int> free{kLogGain};
  if (light.exponent_std > 0.0) free.push_back(kExponent);
  if (light.time_shift_std_s > 0.0) free.push_back(kTimeShift);
  for (int i = kBeamWidth; i < kLightParameters; ++i) free.push_back(i);
  return free;
}

std::vector<int> free_own(const JointProblem& joint, std::size_t receiver) {
  std::vector<int> free{kBackground, kDrift};
  if (receiver > 0 && joint.receivers[receiver].receiver.log_ratio_std > 0.0)
    free.push_back(kLogRatio);
  if (receiver > 0 && joint.receivers[receiver].receiver.ahead_std_m > 0.0) free.push_back(kAhead);
  return free;
}

void add_light(const JointProblem& joint, Unknowns& unknowns, double span_s,
               ceres::LossFunction* loss, ceres::Problem& problem) {
  for (std::size_t r = 0; r < joint.receivers.size(); ++r) {
    const Lit& lit = joint.receivers[r];
    double* own = unknowns.own[r].data();
    for (const LitBlock& block : lit.blocks)
      problem.AddResidualBlock(new BlockResidual(joint.light, lit.receiver, block), loss,
                               unknowns.path.data(), unknowns.light.data(), own);
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<ReceiverPrior, kReceiverPriors, kReceiverParameters>(
            new ReceiverPrior{&lit.receiver, lit.start[kBackground], span_s}),
        nullptr, own);
    hold_fixed_all_but(free_own(joint, r), kReceiverParameters, own, problem);
  }
  problem.AddResidualBlock(
      new ceres::AutoDiffCostFunction<LightPrior, kLightPriors, kPathParameters, kLightParameters>(
          new LightPrior{&joint.light}),
      nullptr, unknowns.path.data(), unknowns.light.data());
  hold_fixed_all_but(free_light(joint.light), kLightParameters, unknowns.light.data(), problem);
}

Outcome<Solved> solve_joint(const JointProblem& joint, Unknowns& unknowns, double span_s,
                            bool light_first) {
  ceres::HuberLoss bearing_loss(kHuberBound), power_loss(kHuberBound_1d);
  ceres::Problem::Options options;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(options);
  add_geometry(joint.geometry, unknowns.path.data(), free_parameters(joint.geometry), &bearing_loss,
               problem);
  add_light(joint, unknowns, span_s, &power_loss, problem);

  // First the light alone on the camera's trajectory: from further away the joint fit can settle in
  // a wrong minimum.
  if (light_first) {
    problem.SetParameterBlockConstant(unknowns.path.data());
    minimise(problem, nullptr, kTolerance);
    problem.SetParameterBlockVariable(unknowns.path.data());
  }
  std::vector<double*> blocks{unknowns.path.data(), unknowns.light.data()};
  for (ReceiverVector& own : unknowns.own) blocks.push_back(own.data());
  const auto outcome = solve(problem, blocks, kTolerance);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) return *miss;
  Solved solved;
  solved.fit.parameters = unknowns.path;
  const std::vector<int> free = free_parameters(joint.geometry);
  const Solution& solution = std::get<Solution>(outcome);
  solved.covariance = solution.covariance;
  for (std::size_t i = 0; i < free.size(); ++i)
    for (std::size_t j = 0; j < free.size(); ++j)
      solved.fit.covariance(free[i], free[j]) =
          solution.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  for (std::size_t r = 0; r < joint.receivers.size(); ++r) {
    const Lit& lit = joint.receivers[r];
    Eigen::VectorXd errors(static_cast<Eigen::Index>(lit.blocks.size()));
    for (std::size_t i = 0; i < lit.blocks.size(); ++i) {
      double residual = 0.0;
      const std::array<const double*, 3> all{unknowns.path.data(), unknowns.light.data(),
                                             unknowns.own[r].data()};
      BlockResidual(joint.light, lit.receiver, lit.blocks[i])
          .Evaluate(all.data(), &residual, nullptr);
      errors[static_cast<Eigen::Index>(i)] = residual * lit.blocks[i].sigma;
    }
    solved.errors.push_back(std::move(errors));
  }
  return solved;
}

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

std::vector<PassGainRatio> gain_ratios(const JointProblem& joint, const Unknowns& unknowns,
                                       const Solved& solved) {
  std::vector<PassGainRatio> ratios;
  // Without the site's first photodiode the pass has them to another.
  if (joint.receivers.front().photodiode != 0) return ratios;
  std::size_t begin = free_parameters(joint.geometry).size() + free_light(joint.light).size();
  for (std::size_t r = 0; r < joint.receivers.size(); ++r) {
    const std::vector<int> own = free_own(joint, r);
    const Lit& lit = joint.receivers[r];
    if (const auto found = std::ranges::find(own, kLogRatio); found != own.end()) {
      const auto at =
          static_cast<Eigen::Index>(begin) + static_cast<Eigen::Index>(found - own.begin());
      ratios.push_back({lit.photodiode, unknowns.own[r][kLogRatio] - lit.receiver.log_ratio,
                        std::sqrt(solved.covariance(at, at)), lit.receiver.log_ratio_std});
    }
    begin += own.size();
  }
  return ratios;
}

// Why this solution is not to be used, if so.
std::optional<Miss> gate(const JointProblem& joint, const Solved& solved,
                         const Trajectory& camera_only) {
  constexpr double kWorstChi2 = 1.3;
  if (chi2_per_block(joint, solved.errors, kUnmodelled.back()) > kWorstChi2) return Miss::bad_fit;
  constexpr double kMostPull = 10.0;  // half a chi-square; the path has at most ten unknowns
  const auto moved = geometry_cost(joint.geometry, solved.fit.parameters);
  if (!moved || *moved - camera_only.fit.cost > kMostPull) return Miss::sensors_contradict;
  return std::nullopt;
}

}  // namespace

Outcome<JointFit> fit_joint(const Trajectory& camera_only, const Site& site,
                            std::span<const VehiclePower> power, double from_s, double to_s) {
  JointProblem joint;
  if (const auto miss = prepare_joint(camera_only, site, power, from_s, to_s, joint)) return *miss;

  Unknowns unknowns;
  unknowns.path = camera_only.fit.parameters;
  unknowns.light[kExponent] = joint.light.exponent;
  unknowns.light[kLogGain] = first_log_gain(joint, unknowns.path, unknowns.light);
  for (const Lit& lit : joint.receivers) unknowns.own.push_back(lit.start);
  // First with the least trust in the light; then, if that holds, with as much as it deserves.
  std::vector<double> factors(joint.receivers.size(), 1.0);
  set_sigmas(joint, kUnmodelled.back(), factors);
  const auto first = solve_joint(joint, unknowns, to_s - from_s, true);
  // All unknowns have priors or start from the bearings: a fit that runs away does not fit.
  if (std::holds_alternative<Miss>(first)) return Miss::bad_fit;
  Solved solved = std::get<Solved>(first);
  if (const auto miss = gate(joint, solved, camera_only)) return *miss;
  const double share = unmodelled_share(joint, solved.errors);
  for (std::size_t r = 0; r < factors.size(); ++r)
    factors[r] = correlation_factor(joint.receivers[r], solved.errors[r], share);
  set_sigmas(joint, share, factors);
  Unknowns sharper_unknowns = unknowns;
  const auto second = solve_joint(joint, sharper_unknowns, to_s - from_s, false);
  const Solved* sharper = std::get_if<Solved>(&second);
  if (sharper && !gate(joint, *sharper, camera_only)) {
    solved = *sharper;
    unknowns = sharper_unknowns;
  }

  JointFit fit;
  fit.gain_ratios = gain_ratios(joint, unknowns, solved);
  fit.samples = joint.samples;
  fit.power_chi2_per_block = chi2_per_block(joint, solved.errors, kUnmodelled.back());
  fit.trajectory = camera_only;
  fit.trajectory.fit.parameters = solved.fit.parameters;
  fit.trajectory.fit.covariance = solved.fit.covariance;
  fit.trajectory.fit.cost = *geometry_cost(joint.geometry, solved.fit.parameters);
  return fit;
}

}  // namespace vildar
