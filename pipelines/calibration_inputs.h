#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "types/site.h"

namespace CLI {
class App;
}

namespace vildar {

/// What a calibration from recorded runs is given.
struct RunsArguments {
  std::vector<std::filesystem::path> runs;
  std::filesystem::path site, out;
  bool json = false;
};
/// Adds these to a subcommand, whose callback is `calibrate` and then exit code 0.
void add_runs_arguments(CLI::App& command, std::function<void(const RunsArguments&)> calibrate,
                        int& exit_code);

/// What run.json says that a run was given.
struct GivenFile {
  std::string role, path, sha256;
};
/// Empty where it cannot be read, which is told by who needs it.
std::vector<GivenFile> inputs_of_run(const std::filesystem::path& run);

/// The site of a camera that stands still; throws ConfigError where it has none, or one that
/// drives.
Site load_fixed_site(const std::filesystem::path& file);

/// Throws ConfigError where a run or its clip is given twice: its passes would count twice.
void refuse_repeated(std::span<const std::filesystem::path> runs);

/// A share as a report shows it, e.g. "2.70 %".
std::string percent_text(double share);

}  // namespace vildar
