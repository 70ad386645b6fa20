#pragma once

#include <filesystem>
#include <vector>

#include "types/site.h"
#include "types/vehicle_track.h"

namespace vildar {

/// A vehicle that a run followed.
struct RecordedPass {
  VehicleTrack track;
  bool sound = false;  ///< it has a speed, or had it withheld as too uncertain alone
};

/// Every vehicle of a run, read back from its speeds.csv and tracks.csv. Throws InputError where
/// these cannot be read, are of an earlier version, or do not fit the site's camera.
std::vector<RecordedPass> read_recorded_passes(const std::filesystem::path& run_folder,
                                               const CameraSite& camera);

}  // namespace vildar
