#pragma once

#include "track/association.h"
#include "track/attitude.h"
#include "track/road_view.h"

namespace vildar {

/// Whether a light stands in the world, though the camera, on its stand or held by hand, may shake:
/// in a second and more it has moved by less than a metre or 5 px, or has gone to and fro and got
/// nowhere, or for 2 s has kept its angle to another light of its own beside it while both moved by
/// less than 0.1 rad: lights of vehicles part as they come nearer. Never before a camera that
/// drives.
bool stands_in_the_world(const Lamp& lamp, const Lamps& lamps, const RoadView& view);

/// A lamp where the camera at rest would have seen it, in the frames in which its turn is told.
Lamp steadied(const Lamp& lamp, const Attitude& attitude, const RoadView& view);

}  // namespace vildar
