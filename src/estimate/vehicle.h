#pragma once

#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include "estimate/trajectory.h"
#include "types/power.h"
#include "types/result.h"
#include "types/site.h"
#include "types/vehicle_track.h"

namespace vildar {

/// The speed of one vehicle by every method that applies, and what is known of it in each frame.
struct VehicleEstimate {
  VehicleResult result;
  std::vector<TrackRow> rows;            ///< one per sighting, in the track's order
  std::vector<Trajectory> trajectories;  ///< that a speed from the camera is of; empty without one
};

/// A photodiode's trace as offered to a vehicle's estimate; `trace` is not null and outlives the
/// call.
struct VehiclePower {
  const PowerTrace* trace = nullptr;
  bool shared = false;  ///< another vehicle feeds this photodiode during this pass
  /// The same, also where it is shared, with the light of others taken out; empty where there is
  /// light that no vehicle in view explains, null where the law tells nothing. Outlives the call.
  const PowerTrace* own_light = nullptr;
};

/// The pass, in the light of any photodiode, that the camera's way of a vehicle says is its own;
/// and the whole traces, which outlive the call.
struct OwnPass {
  PowerPass pass;
  std::span<const PowerTrace> traces;
};

/// Speed from the camera's bearings, from light, and from both. The delay between photodiodes is
/// that of `own_pass`, or without one that of the time in which the vehicle is alone on `power`.
/// What the data do not determine is withheld with its reason. Throws std::invalid_argument where
/// the site has no camera.
VehicleEstimate estimate_vehicle(const VehicleTrack& track, const Site& site,
                                 std::span<const VehiclePower> power,
                                 const std::optional<OwnPass>& own_pass = {});

/// Takes the speed, its trajectories and what came with them out of `estimate`, and out of its
/// results by `methods`; `warning` says why.
void withhold(VehicleEstimate& estimate, Miss miss, std::initializer_list<Method> methods,
              const std::string& warning);

/// Speed of one pass from photodiodes alone, `found` in the light of any of them. `pass_number`
/// becomes the track id; times of the result are in photodiode time plus the mean of the site's
/// offset. Throws std::invalid_argument where `traces` is empty.
VehicleResult estimate_pass(const PowerPass& found, int pass_number, const Site& site,
                            std::span<const PowerTrace> traces);

}  // namespace vildar
