#include "estimate/joint_fit.h"

#include <algorithm>
#include <cmath>

#include <ceres/ceres.h>

#include "estimate/joint_cost.h"
#include "estimate/power_blocks.h"
#include "estimate/solve.h"
#include "optics/channel.h"

namespace vildar {
namespace {

// Share of the signal that neither gain nor beam structure of the model accounts for.
constexpr double kUnmodelled = 0.01;
constexpr double kClearSigmas = 5.0;
constexpr std::size_t kFewestBlocks = 10;
constexpr double kHuberBound_1d = 2.0;

using LightVector = std::array<double, kLightParameters>;
using ReceiverVector = std::array<double, kReceiverParameters>;

struct Lit {
  Receiver receiver;
  std::vector<PowerBlock> blocks;
  ReceiverVector start{};
};

struct JointProblem {
  GeometryProblem geometry;
  LightSetting light;
  std::vector<Lit> receivers;
  std::int64_t samples = 0;
};

LightSetting light_setting(const Site& site, double time_offset_std_s) {
  LightSetting light;
  light.time_shift_std_s = time_offset_std_s;
  if (!site.channel || !site.channel->beam.empty()) {
    // Free space, and R / D for the photodiode's own incidence; the beam is left to its multiplier.
    light.cosine_exponent = 1.0;
    return light;
  }
  const ChannelSite& channel = *site.channel;
  if (channel.path_loss_exponent) {
    light.exponent = channel.path_loss_exponent->mean;
    light.exponent_std = channel.path_loss_exponent->std;
  } else {
    light.exponent_std = 0.3;
  }
  if (channel.half_power_angle_rad)
    light.cosine_exponent = lambertian_order(Radians(*channel.half_power_angle_rad)) + 1.0;
  if (channel.gain_db && channel.path_loss_exponent && channel.lamp_power_w.mean > 0.0) {
    constexpr double kKnown = 0.02;
    light.log_gain = std::log(ratio_from_db(channel.gain_db->mean) * channel.lamp_power_w.mean);
    light.log_gain_std =
        std::max(kKnown, std::hypot(0.1 * std::log(10.0) * channel.gain_db->std,
                                    channel.lamp_power_w.std / channel.lamp_power_w.mean));
  }
  return light;
}

// Part of the track in which the beam model holds for this photodiode and it faces the vehicle.
bool lights(const Trajectory& trajectory, const PhotodiodeSite& site, const Receiver& receiver,
            double time_s) {
  const MotionState state = trajectory.at(time_s);
  const Eigen::Vector3d toward(state.range_m - receiver.position_m.x(),
                               state.lateral_m - receiver.position_m.y(),
                               trajectory.lamp_height_m() - receiver.position_m.z());
  if (!(toward.x() > 0.0) || !(state.over_ground_mps > 0.0)) return false;
  const auto place = vehicle_point(trajectory.fit.parameters.data(), trajectory.problem.setting,
                                   time_s - trajectory.problem.reference_s);
  if (std::abs(std::atan2(toward.y(), toward.x()) - place.heading_rad) > kBeamEdge_rad)
    return false;
  const Eigen::Vector3d axis(std::cos(site.pitch_rad) * std::cos(site.yaw_rad),
                             std::cos(site.pitch_rad) * std::sin(site.yaw_rad),
                             std::sin(site.pitch_rad));
  return axis.dot(toward.normalized()) > std::cos(site.half_field_of_view_rad);
}

std::optional<Lit> lit_receiver(const PowerTrace& trace, const Trajectory& trajectory,
                                const Site& site, double from_s, double to_s) {
  const PhotodiodeSite& diode = site.photodiodes.at(static_cast<std::size_t>(trace.photodiode));
  Lit lit;
  for (int axis = 0; axis < 3; ++axis)
    lit.receiver.position_m[axis] = diode.position_m[static_cast<std::size_t>(axis)].mean;
  lit.receiver.log_ratio = std::log(diode.gain_ratio.mean);
  lit.receiver.log_ratio_std = diode.gain_ratio.std / diode.gain_ratio.mean;
  lit.receiver.middle_s = 0.5 * (from_s + to_s);
  const double offset_s = diode.time_offset_s.mean;
  // One mains period, so that twice its frequency averages out.
  const double block_s = 1.0 / site.mains_hz;
  double brightest_w = 0.0;
  for (const PowerBlock& block :
       block_means(trace, from_s - offset_s, to_s - offset_s, block_s, offset_s)) {
    if (!lights(trajectory, diode, lit.receiver, block.time_s)) continue;
    lit.blocks.push_back(block);
    brightest_w = std::max(brightest_w, block.power_w - trace.ambient_w);
  }
  if (!(brightest_w > kClearSigmas * trace.noise_sigma_w)) return std::nullopt;
  for (PowerBlock& block : lit.blocks)
    block.sigma_w =
        std::hypot(block.sigma_w, kUnmodelled * std::max(0.0, block.power_w - trace.ambient_w));
  lit.start = {trace.ambient_w, 0.0, lit.receiver.log_ratio};
  return lit;
}

void scale_power(JointProblem& problem) {
  double unit_w = 0.0;
  for (const Lit& lit : problem.receivers)
    for (const PowerBlock& block : lit.blocks)
      unit_w = std::max(unit_w, block.power_w - lit.start[kBackground]);
  problem.light.power_unit_w = unit_w;
  problem.light.log_gain -= std::log(unit_w);
  for (Lit& lit : problem.receivers) {
    lit.start[kBackground] /= unit_w;
    for (PowerBlock& block : lit.blocks) {
      block.power_w /= unit_w;
      block.sigma_w /= unit_w;
    }
  }
}

// With the camera's trajectory, the gain that the brightest stretch asks for.
double first_log_gain(const JointProblem& problem, const PathVector& path, LightVector light) {
  light[kLogGain] = 0.0;
  double sum = 0.0, weight = 0.0;
  for (const Lit& lit : problem.receivers)
    for (const PowerBlock& block : lit.blocks) {
      const double signal = block.power_w - lit.start[kBackground];
      double value = 0.0;
      if (!(signal > 3.0 * block.sigma_w) ||
          !log_power(path.data(), light.data(), problem.light, lit.receiver.position_m,
                     block.time_s - problem.geometry.reference_s, value))
        continue;
      const double w = std::pow(signal / block.sigma_w, 2);
      sum += w * (std::log(signal) - value - lit.start[kLogRatio]);
      weight += w;
    }
  return weight > 0.0 ? sum / weight : 0.0;
}

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
  bool shared = false;
  double offset_std_s = 0.0;
  for (const VehiclePower& offered : power) {
    shared = shared || offered.shared;
    if (offered.shared) continue;
    const auto lit = lit_receiver(*offered.trace, camera_only, site, from_s, to_s);
    if (!lit) continue;
    joint.receivers.push_back(*lit);
    for (const PowerBlock& block : lit->blocks) joint.samples += block.samples;
    offset_std_s =
        site.photodiodes[static_cast<std::size_t>(offered.trace->photodiode)].time_offset_s.std;
  }
  if (joint.receivers.empty()) return shared ? Miss::several_vehicles : Miss::below_noise;
  std::size_t blocks = 0;
  for (const Lit& lit : joint.receivers) blocks += lit.blocks.size();
  if (blocks < kFewestBlocks) return Miss::too_few_samples;
  joint.geometry = camera_only.problem;
  joint.light = light_setting(site, offset_std_s);
  joint.light.problem = &joint.geometry;
  scale_power(joint);

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
