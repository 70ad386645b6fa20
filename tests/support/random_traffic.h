#pragma once

#include <cstdint>

#include "synth/scenario.h"

namespace vildar {

/// Four seconds of traffic both ways on five lanes, seen from a mast 5 m high: cars, lorries and
/// motorcycles, at most `vehicles` of them (fewer where the road is full), all within 110 m at half
/// time. What the site file tells as a prior is drawn from it. Equal arguments, equal scene.
Scenario random_traffic(std::uint64_t seed, int vehicles, bool wet);

}  // namespace vildar
