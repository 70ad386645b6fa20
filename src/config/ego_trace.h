#pragma once

#include <filesystem>
#include <vector>

#include "core/error.h"
#include "types/site.h"

namespace vildar {

/// The motion of a dashcam's own vehicle: CSV with the header `t_s,speed_mps[,yaw_rate_rad_per_s]`,
/// `#` comments and empty lines allowed, times strictly increasing, speeds from 0 to 100 m/s, with
/// changes and turns that tyres can give (9.8 and 15 m/s^2, and 2 m/s of noise). What does not hold
/// is appended to `problems` with its line; the samples are then not to be used.
std::vector<EgoSample> read_ego_trace(const std::filesystem::path& file,
                                      std::vector<Problem>& problems);

}  // namespace vildar
