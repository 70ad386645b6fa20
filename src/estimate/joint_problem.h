#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "estimate/joint_cost.h"
#include "estimate/trajectory.h"
#include "estimate/vehicle.h"

namespace vildar {

using LightVector = std::array<double, kLightParameters>;
using ReceiverVector = std::array<double, kReceiverParameters>;

/// What one photodiode received of the vehicle, in power units.
struct Lit {
  int photodiode = 0;  ///< index in the site
  Receiver receiver;
  std::vector<LitBlock> blocks;
  ReceiverVector start{};
  std::int64_t samples = 0;
};

/// Bearings and power of one vehicle, ready to be fitted together. `light.problem` points at
/// `geometry`, so the struct stays where it was made.
struct JointProblem {
  JointProblem() { light.problem = &geometry; }
  JointProblem(const JointProblem&) = delete;
  JointProblem& operator=(const JointProblem&) = delete;

  GeometryProblem geometry;
  LightSetting light;
  std::vector<Lit> receivers;
  std::int64_t samples = 0;  ///< photodiode samples behind all blocks
  double span_s = 0.0;       ///< length of the part of the traces
};

/// Fills `joint` with the part of the traces, between two clip times, in which the vehicle faces
/// each photodiode within the beam model's angles; the power unit is the brightest block's signal.
/// Returns why the power cannot be used, if so: several_vehicles, below_noise, too_few_samples.
std::optional<Miss> prepare_joint(const Trajectory& camera_only, const Site& site,
                                  std::span<const VehiclePower> power, double from_s, double to_s,
                                  JointProblem& joint);

/// Sigmas of all blocks from their noise, a share of the light that the model leaves out, and a
/// factor for each photodiode.
void set_sigmas(JointProblem& joint, double unmodelled, std::span<const double> factors);

}  // namespace vildar
