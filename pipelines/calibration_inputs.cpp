#include "pipelines/calibration_inputs.h"

#include <fstream>
#include <memory>
#include <set>
#include <utility>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "config/site_file.h"
#include "core/error.h"
#include "core/text.h"
#include "pipelines/safe_output.h"

namespace vildar {

namespace fs = std::filesystem;

namespace {

// What its run.json says that a run was given; what cannot be read is told by who needs it.
std::vector<fs::path> inputs_of_run(const fs::path& run) {
  std::ifstream stream(run / "run.json");
  const nlohmann::json json = nlohmann::json::parse(stream, nullptr, false);
  std::vector<fs::path> inputs;
  if (!json.is_object() || !json.contains("inputs") || !json["inputs"].is_array()) return inputs;
  for (const nlohmann::json& input : json["inputs"])
    if (input.is_object() && input.contains("path") && input["path"].is_string())
      inputs.emplace_back(input["path"].get<std::string>());
  return inputs;
}

}  // namespace

void add_runs_arguments(CLI::App& command, std::function<void(const RunsArguments&)> calibrate,
                        int& exit_code) {
  auto arguments = std::make_shared<RunsArguments>();
  command.add_option("RUN_DIR", arguments->runs, "Folders that runs of this site wrote")
      ->required();
  command.add_option("--site", arguments->site, "Site file")->required();
  command.add_option("--out", arguments->out, "Site file to write")->required();
  command.add_flag("--json", arguments->json, "Print JSON in place of the text");
  command.callback([arguments, calibrate = std::move(calibrate), &exit_code] {
    refuse_to_replace(arguments->out, ".yaml", {arguments->site});
    refuse_to_replace(arguments->out, ".yaml", arguments->runs);
    for (const fs::path& run : arguments->runs)
      refuse_to_replace(arguments->out, ".yaml", inputs_of_run(run));
    calibrate(*arguments);
    exit_code = 0;
  });
}

Site load_fixed_site(const fs::path& file) {
  Site site = load_site(file);
  if (!site.camera)
    throw ConfigError(
        {{file.string(), 0, "", "the site has no camera", "add a `camera:` section"}});
  if (site.ego)
    throw ConfigError({{file.string(), 0, "", "the camera drives (`ego:`)",
                        "learn from a camera that stands still; a dashcam has no fixed mount"}});
  return site;
}

void refuse_repeated(std::span<const fs::path> runs) {
  std::set<fs::path> folders;
  for (const fs::path& run : runs)
    if (!folders.insert(fs::weakly_canonical(run)).second)
      throw ConfigError({{run.string(), 0, "", "the run is given twice", "name each run once"}});
}

std::string percent_text(double share) { return fixed_text(100.0 * share, 2) + " %"; }

}  // namespace vildar
