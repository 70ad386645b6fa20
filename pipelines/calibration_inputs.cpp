#include "pipelines/calibration_inputs.h"

#include <fstream>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "config/site_file.h"
#include "core/error.h"
#include "core/text.h"
#include "pipelines/safe_output.h"

namespace vildar {

namespace fs = std::filesystem;

std::vector<GivenFile> inputs_of_run(const fs::path& run) {
  std::ifstream stream(run / "run.json");
  const nlohmann::json json = nlohmann::json::parse(stream, nullptr, false);
  std::vector<GivenFile> inputs;
  if (!json.is_object() || !json.contains("inputs") || !json["inputs"].is_array()) return inputs;
  const auto text = [](const nlohmann::json& of, const char* key) {
    return of.is_object() && of.contains(key) && of[key].is_string() ? of[key].get<std::string>()
                                                                     : std::string();
  };
  for (const nlohmann::json& input : json["inputs"])
    inputs.push_back({text(input, "role"), text(input, "path"), text(input, "sha256")});
  return inputs;
}

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
      for (const GivenFile& given : inputs_of_run(run))
        if (!given.path.empty()) refuse_to_replace(arguments->out, ".yaml", {given.path});
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
  std::map<std::string, fs::path> run_of_clip;
  for (const fs::path& run : runs) {
    if (!folders.insert(fs::weakly_canonical(run)).second)
      throw ConfigError({{run.string(), 0, "", "the run is given twice", "name each run once"}});
    for (const GivenFile& given : inputs_of_run(run)) {
      if (given.role != "clip" || given.sha256.empty()) continue;
      const auto [other, is_new] = run_of_clip.emplace(given.sha256, run);
      if (!is_new)
        throw ConfigError(
            {{run.string(), 0, "",
              "its clip is that of " + other->second.string() + ", whose passes would count twice",
              "name one run of each clip"}});
    }
  }
}

std::string percent_text(double share) { return fixed_text(100.0 * share, 2) + " %"; }

}  // namespace vildar
