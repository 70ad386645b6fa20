#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "synth/scenario.h"

namespace vildar {

/// Called now and then with the frames done and their total.
using RenderProgress = std::function<void(std::int64_t done, std::int64_t total)>;

/// Writes what the sensors of a scenario record, and the truth: the clip (with a
/// camera), photodiode.csv (with photodiodes), site.yaml, truth_vehicles.csv, truth_tracks.csv;
/// each file whole or not at all. Returns the files written. Throws OutputError where one cannot be
/// written.
std::vector<std::filesystem::path> render(const Scenario& scenario,
                                          const std::filesystem::path& out_dir,
                                          const RenderProgress& progress);

}  // namespace vildar
