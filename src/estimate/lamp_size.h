#pragma once

#include <span>

#include "estimate/trajectory.h"
#include "types/blob.h"
#include "types/site.h"
#include "types/vehicle_track.h"

namespace vildar {

/// A lamp in several pictures, at distances (m, in whatever scale) with one entry for each light.
/// Coding with loss errs at a lamp's rim, where radius and light are nearly one number; but a lamp
/// has one size, which all pictures tell together: each light becomes what it is at that size, with
/// its radius and both sigmas. Throws std::invalid_argument where the lengths differ, there is no
/// light, or one has no radius or no sigma of it.
void hold_size(std::span<const double> distance_m, std::span<LampLight> lights);

/// The track with the lights of each lamp held to one size, at the distances of the trajectory:
/// those of pictures coded with loss within the part of the track that it was fitted to.
VehicleTrack with_held_sizes(VehicleTrack track, const Trajectory& trajectory,
                             const CameraSite& camera);

}  // namespace vildar
