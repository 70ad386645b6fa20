#pragma once

#include "types/vehicle_track.h"

namespace vildar {

/// The track without lamps that are mostly hidden, as by a vehicle ahead: what is left of one lies
/// to one side of its middle. The two lamps of a pair are alike; where they are within a factor of
/// two in a fifth of the pictures that show both (five and more), one that is fainter than that
/// beside the other in a tenth of them (five and more) is taken for a part of a lamp, or for
/// something else. A lamp that is always the fainter stays. One that goes, or comes, 0.4 s and more
/// before the other is left out for as long as it has less of the other's light by a tenth than in
/// the quarter of the pictures at the other end, if that comes to a third and more. Of a lamp alone
/// the sightings at either end go, up to a quarter of all, that have less light by a quarter of a
/// nat than those within a second after ask for.
VehicleTrack without_half_hidden(VehicleTrack track);

}  // namespace vildar
