#pragma once

#include <filesystem>
#include <vector>

#include "types/site.h"
#include "types/vehicle_track.h"

namespace vildar {

/// The vehicles that a run followed and gave a speed, or withheld it as too uncertain, read back
/// from its speeds.csv and tracks.csv. Throws InputError where these cannot be read, are of an
/// earlier version, or do not fit the site's camera.
std::vector<VehicleTrack> read_recorded_passes(const std::filesystem::path& run_folder,
                                               const CameraSite& camera);

}  // namespace vildar
