#pragma once

#include <optional>
#include <span>

#include "types/camera_turn.h"
#include "types/site.h"
#include "types/vehicle_track.h"

namespace vildar {

/// A vehicle as a shaken camera would have seen it at rest.
struct SteadyView {
  VehicleTrack track;  ///< lamps moved, their sigmas widened by those of the turns
  Site site;           ///< its pose widened by what the mean of the turns leaves open
};

/// `turns` has one entry per sighting. Nothing where none is known, or the site has no camera.
std::optional<SteadyView> steady_view(const VehicleTrack& track,
                                      std::span<const std::optional<CameraTurn>> turns,
                                      const Site& site);

}  // namespace vildar
