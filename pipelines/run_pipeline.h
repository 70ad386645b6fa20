#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "capture/clip_source.h"
#include "sink/report.h"
#include "sink/run_summary.h"
#include "types/result.h"

namespace vildar {

struct RunOptions {
  std::optional<std::filesystem::path> clip;
  std::optional<std::filesystem::path> photodiode;
  std::filesystem::path site;
  std::filesystem::path out;
  ClipOptions clip_options;
  bool annotate = false;
  bool blobs = false;
};

struct RunOutcome {
  RunSummary summary;
  std::vector<VehicleResult> vehicles;
};

/// The main job: reads the inputs, measures, writes the files of the contract (SPEC 4) into
/// `options.out`. Throws ConfigError, InputError or OutputError.
RunOutcome run_pipeline(const RunOptions& options);

}  // namespace vildar
