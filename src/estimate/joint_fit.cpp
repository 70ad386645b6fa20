#include "estimate/joint_fit.h"

#include <algorithm>

#include <ceres/ceres.h>

#include "estimate/joint_problem.h"
#include "estimate/solve.h"

namespace vildar {
namespace {

constexpr double kHuberBound_1d = 2.0;

struct LightPrior {
  const LightSetting* setting;

  template <class T>
  bool operator()(const T* path, const T* light, T* residual) const {
    // Loose enough for any headlamp: e-fold at 0.3 rad, half an e-fold of ripple.
    constexpr double kWidth = 12.0, kTilt = 10.0, kWave = 0.5;
    const auto& s = *setting;
    residual[0] =
        s.log_gain_std > 0.0
            ? (light[kLogGain] + light[kExponent] * path[kLogScale] - s.log_gain) / s.log_gain_std
            : T(0.0);
    residual[1] = s.exponent_std > 0.0 ? (light[kExponent] - s.exponent) / s.exponent_std : T(0.0);
    residual[2] = s.time_shift_std_s > 0.0 ? light[kTimeShift] / s.time_shift_std_s : T(0.0);
    residual[3] = light[kBeamWidth] / kWidth;
    residual[4] = light[kBeamTilt] / kTilt;
    for (int k = 1; k <= kBeamWaves; ++k)
      residual[4 + k] = light[kBeamWave + k - 1] * static_cast<double>(k) / kWave;
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
    return true;
  }
};

struct Unknowns {
  PathVector path;
  LightVector light{};
  std::vector<ReceiverVector> own;
};

struct Solved {
  GeometryFit fit;
  double power_chi2 = 0.0;
  std::size_t blocks = 0;
};

std::vector<int> free_light(const LightSetting& light) {
  std::vector<int> free{kLogGain};
  if (light.exponent_std > 0.0) free.push_back(kExponent);
  if (light.time_shift_std_s > 0.0) free.push_back(kTimeShift);
  for (int i = kBeamWidth; i < kLightParameters; ++i) free.push_back(i);
  return free;
}

void add_light(const JointProblem& joint, Unknowns& unknowns, double span_s,
               ceres::LossFunction* loss, ceres::Problem& problem) {
  for (std::size_t r = 0; r < joint.receivers.size(); ++r) {
    const Lit& lit = joint.receivers[r];
    double* own = unknowns.own[r].data();
    for (const PowerBlock& block : lit.blocks)
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<BlockResidual, 1, kPathParameters, kLightParameters,
                                          kReceiverParameters>(
              new BlockResidual{&joint.light, &lit.receiver, block}),
          loss, unknowns.path.data(), unknowns.light.data(), own);
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<ReceiverPrior, 3, kReceiverParameters>(
                                 new ReceiverPrior{&lit.receiver, lit.start[kBackground], span_s}),
                             nullptr, own);
    std::vector<int> free{kBackground, kDrift};
    if (r > 0 && lit.receiver.log_ratio_std > 0.0) free.push_back(kLogRatio);
    hold_fixed_all_but(free, kReceiverParameters, own, problem);
  }
  problem.AddResidualBlock(
      new ceres::AutoDiffCostFunction<LightPrior, kLightPriors, kPathParameters, kLightParameters>(
          new LightPrior{&joint.light}),
      nullptr, unknowns.path.data(), unknowns.light.data());
  hold_fixed_all_but(free_light(joint.light), kLightParameters, unknowns.light.data(), problem);
}

Outcome<Solved> solve_joint(const JointProblem& joint, Unknowns& unknowns, double span_s) {
  ceres::HuberLoss bearing_loss(kHuberBound), power_loss(kHuberBound_1d);
  ceres::Problem::Options options;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(options);
  add_geometry(joint.geometry, unknowns.path.data(), &bearing_loss, problem);
  add_light(joint, unknowns, span_s, &power_loss, problem);

  // First the light alone on the camera's trajectory: from further away the joint fit can settle in
  // a wrong minimum.
  problem.SetParameterBlockConstant(unknowns.path.data());
  minimise(problem);
  problem.SetParameterBlockVariable(unknowns.path.data());
  std::vector<double*> blocks{unknowns.path.data(), unknowns.light.data()};
  for (ReceiverVector& own : unknowns.own) blocks.push_back(own.data());
  const auto outcome = solve(problem, blocks);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) return *miss;
  Solved solved;
  solved.fit.parameters = unknowns.path;
  const std::vector<int> free = free_parameters(joint.geometry);
  const Solution& solution = std::get<Solution>(outcome);
  for (std::size_t i = 0; i < free.size(); ++i)
    for (std::size_t j = 0; j < free.size(); ++j)
      solved.fit.covariance(free[i], free[j]) =
          solution.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  for (std::size_t r = 0; r < joint.receivers.size(); ++r)
    for (const PowerBlock& block : joint.receivers[r].blocks) {
      double residual = 0.0;
      BlockResidual{&joint.light, &joint.receivers[r].receiver, block}(
          unknowns.path.data(), unknowns.light.data(), unknowns.own[r].data(), &residual);
      solved.power_chi2 += residual * residual;
      ++solved.blocks;
    }
  return solved;
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
  const auto outcome = solve_joint(joint, unknowns, to_s - from_s);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) return *miss;
  const Solved& solved = std::get<Solved>(outcome);

  JointFit fit;
  fit.samples = joint.samples;
  fit.power_chi2_per_block = solved.power_chi2 / static_cast<double>(solved.blocks);
  constexpr double kWorstChi2 = 1.3;
  if (fit.power_chi2_per_block > kWorstChi2) return Miss::bad_fit;
  const auto moved = geometry_cost(joint.geometry, unknowns.path);
  constexpr double kMostPull = 10.0;  // half a chi-square; the path has at most ten unknowns
  if (!moved || *moved - camera_only.fit.cost > kMostPull) return Miss::sensors_contradict;
  fit.trajectory = camera_only;
  fit.trajectory.fit.parameters = solved.fit.parameters;
  fit.trajectory.fit.covariance = solved.fit.covariance * std::max(1.0, fit.power_chi2_per_block);
  fit.trajectory.fit.cost = *moved;
  return fit;
}

}  // namespace vildar
