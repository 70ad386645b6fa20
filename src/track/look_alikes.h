#pragma once

#include <cstdint>

#include "track/association.h"
#include "track/pairing.h"

namespace vildar {

/// Gathers, for each lamp in this frame of `spots`, the evidence that it is not the lamp of a
/// vehicle of its own: a reflection on the road (Lamp::mirrored), a part of another vehicle
/// (Lamp::on_vehicle), above where lamps on the road stand (Lamp::above), a glint on the road below
/// one (Lamp::below), or standing in the world (Lamp::fixed), before a camera that sways or not.
void note_look_alikes(const Lamps& lamps, const std::vector<Spot>& spots, const Vehicles& vehicles,
                      const RoadView& view, std::int64_t frame, bool sways = false);

}  // namespace vildar
