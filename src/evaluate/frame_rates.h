#pragma once

#include <optional>
#include <span>
#include <vector>

#include "evaluate/folders.h"

namespace vildar {

/// Where the frames that run and truth both number pass at rates that differ by more than a
/// fiftieth: the run's vehicles, their sightings numbered as the frames of the truth at their
/// times. A sighting farther from any than a quarter of the truth's step, or than another sighting
/// of its vehicle, is left out.
std::optional<std::vector<RunVehicle>> numbered_by_time(std::span<const TruthVehicle> truth,
                                                        std::span<const RunVehicle> run);

}  // namespace vildar
