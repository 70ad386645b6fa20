#pragma once

#include "types/vehicle_track.h"

namespace vildar {

/// The track without places of lamps beside which a flasher is lit. From a distance a lamp and the
/// indicator beside it are one light, whose middle and height jump as it flashes. Lit is where a
/// lamp's light, less its steady change (median slope of 0.35 s to either side), is in the upper
/// two thirds between two levels that are 10 % and eight times the scatter
/// of single pictures apart, where flashes and pauses follow one
/// another as UN Regulation 48 has them, 60 to 120 a minute.
VehicleTrack without_flashes(VehicleTrack track);

/// Whether what a camera that stands sees is no vehicle's light but lamps along the road that are
/// lit one after another, as those of road works are: of three steps in four, so long that its way
/// in the 1.2 s before (after, where it recedes) would make them 3 px, it makes less than half. Who
/// crawls in a queue makes more of those at once.
bool lit_in_turn(const VehicleTrack& track);

}  // namespace vildar
