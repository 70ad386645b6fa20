#include "estimate/joint_problem.h"

#include <algorithm>
#include <cmath>

#include "estimate/light_checks.h"
#include "estimate/power_blocks.h"
#include "optics/channel.h"
#include "optics/incidence.h"

namespace vildar {
namespace {

constexpr double kClearSigmas = 5.0;
constexpr std::size_t kFewestBlocks = 10;

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

PathPoint<double> place_at(const Trajectory& trajectory, double time_s) {
  return vehicle_point(trajectory.fit.parameters.data(), trajectory.problem.setting,
                       time_s - trajectory.problem.reference_s);
}

Eigen::Vector3d lamps_from(const Eigen::Vector3d& receiver_m, const PathPoint<double>& place,
                           const Trajectory& trajectory) {
  return Eigen::Vector3d(place.x_m, place.y_m, trajectory.lamp_height_m()) - receiver_m;
}

// Part of the track in which the beam model holds for this photodiode and it faces the vehicle.
bool lights(const Trajectory& trajectory, const PhotodiodeSite& site, const Receiver& receiver,
            double time_s) {
  const PathPoint<double> place = place_at(trajectory, time_s);
  const Eigen::Vector3d toward = lamps_from(receiver.position_m, place, trajectory);
  const PathVector& path = trajectory.fit.parameters;
  const double tau_s = time_s - trajectory.problem.reference_s;
  const double closing_rate = path[kClosingRate] + tau_s * path[kAcceleration] +
                              trajectory.problem.setting.departed_rate(tau_s);
  if (!(toward.x() > 0.0) || !(closing_rate > 0.0)) return false;
  if (std::abs(std::atan2(toward.y(), toward.x()) - place.heading_rad) > kBeamEdge_rad)
    return false;
  return axis_of(site).dot(toward.normalized()) > std::cos(site.half_field_of_view_rad);
}

// Mean of D^-2 over a block by Simpson's rule, over that in its middle.
double bulge_of(const Trajectory& trajectory, const Receiver& receiver, const PowerBlock& block) {
  const auto light = [&](double time_s) {
    return 1.0 /
           lamps_from(receiver.position_m, place_at(trajectory, time_s), trajectory).squaredNorm();
  };
  const double half_s = 0.5 * block.duration_s;
  const double middle = light(block.time_s);
  return (light(block.time_s - half_s) + light(block.time_s + half_s) + 4.0 * middle) /
         (6.0 * middle);
}

std::optional<Lit> lit_receiver(const PowerTrace& trace, const Trajectory& trajectory,
                                const Site& site, double from_s, double to_s) {
  const PhotodiodeSite& diode = site.photodiodes.at(static_cast<std::size_t>(trace.photodiode));
  Lit lit;
  lit.photodiode = trace.photodiode;
  for (int axis = 0; axis < 3; ++axis)
    lit.receiver.position_m[axis] = diode.position_m[static_cast<std::size_t>(axis)].mean;
  lit.receiver.log_ratio = std::log(diode.gain_ratio.mean);
  lit.receiver.log_ratio_std = diode.gain_ratio.std / diode.gain_ratio.mean;
  lit.receiver.ahead_std_m = diode.position_m[0].std;
  lit.receiver.middle_s = 0.5 * (from_s + to_s);
  const double offset_s = diode.time_offset_s.mean;
  // One mains period, so that twice its frequency averages out.
  const double block_s = 1.0 / site.mains_hz;
  double brightest_w = 0.0;
  for (const PowerBlock& block :
       block_means(trace, from_s - offset_s, to_s - offset_s, block_s, offset_s)) {
    if (!lights(trajectory, diode, lit.receiver, block.time_s)) continue;
    const double light_w = block.power_w - trace.ambient_w;
    lit.blocks.push_back({block.time_s, block.power_w, block.sigma_w, std::max(0.0, light_w),
                          bulge_of(trajectory, lit.receiver, block), block.sigma_w});
    lit.samples += block.samples;
    brightest_w = std::max(brightest_w, light_w);
  }
  if (!(brightest_w > kClearSigmas * trace.noise_sigma_w)) return std::nullopt;
  lit.start = {trace.ambient_w, 0.0, lit.receiver.log_ratio, 0.0};
  return lit;
}

void scale_power(JointProblem& problem) {
  double unit_w = 0.0;
  for (const Lit& lit : problem.receivers)
    for (const LitBlock& block : lit.blocks) unit_w = std::max(unit_w, block.light);
  problem.light.power_unit_w = unit_w;
  problem.light.log_gain -= std::log(unit_w);
  for (Lit& lit : problem.receivers) {
    lit.start[kBackground] /= unit_w;
    for (LitBlock& block : lit.blocks)
      for (double* value : {&block.power, &block.noise, &block.light, &block.sigma})
        *value /= unit_w;
  }
}

}  // namespace

void set_sigmas(JointProblem& joint, double unmodelled, std::span<const double> factors) {
  for (std::size_t r = 0; r < joint.receivers.size(); ++r)
    for (LitBlock& block : joint.receivers[r].blocks)
      block.sigma = factors[r] * std::hypot(block.noise, unmodelled * block.light);
}

std::optional<Miss> prepare_joint(const Trajectory& camera_only, const Site& site,
                                  std::span<const VehiclePower> power, double from_s, double to_s,
                                  JointProblem& joint) {
  bool shared = false;
  double offset_std_s = 0.0, log_light_std_most = 0.0;
  std::size_t blocks = 0;
  for (const VehiclePower& offered : power) {
    shared = shared || offered.shared;
    if (offered.shared) continue;
    auto lit = lit_receiver(*offered.trace, camera_only, site, from_s, to_s);
    if (!lit) continue;
    blocks += lit->blocks.size();
    joint.samples += lit->samples;
    joint.receivers.push_back(std::move(*lit));
    const Uncertain& offset_s =
        site.photodiodes[static_cast<std::size_t>(offered.trace->photodiode)].time_offset_s;
    log_light_std_most =
        std::max(log_light_std_most,
                 log_light_std(*offered.trace, from_s - offset_s.mean, to_s - offset_s.mean));
    offset_std_s = offset_s.std;
  }
  if (joint.receivers.empty()) return shared ? Miss::several_vehicles : Miss::below_noise;
  if (blocks < kFewestBlocks) return Miss::too_few_samples;
  joint.span_s = to_s - from_s;
  joint.geometry = camera_only.problem;
  joint.light = light_setting(site, offset_std_s);
  if (joint.light.log_gain_std > 0.0)
    joint.light.log_gain_std = std::hypot(joint.light.log_gain_std, log_light_std_most);
  joint.light.problem = &joint.geometry;
  joint.light.log_scale = camera_only.fit.parameters[kLogScale];
  scale_power(joint);
  return std::nullopt;
}

}  // namespace vildar
