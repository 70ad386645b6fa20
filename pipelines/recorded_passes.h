#pragma once

#include <filesystem>
#include <span>
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

/// Throws ConfigError where half of the passes of one of the runs in `folders` are another's to the
/// last digit: one clip in two containers, whose passes would count twice.
void refuse_same_passes(std::span<const std::filesystem::path> folders,
                        std::span<const std::vector<VehicleTrack>> runs);

}  // namespace vildar
