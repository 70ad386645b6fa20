#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "core/atomic_file.h"
#include "pipelines/commands.h"
#include "pipelines/interrupt.h"
#include "pipelines/progress.h"
#include "pipelines/safe_output.h"
#include "synth/frame_times.h"
#include "synth/random_scene.h"
#include "synth/render.h"

namespace vildar {
namespace {

struct RenderArguments {
  std::string scenario;
  std::string out;
  int random = 0;
  std::uint64_t seed = 1;
  std::string preset = "straight";
  bool scenario_only = false;
  bool json = false;
};

// Folders 0001, 0002, ... of scenes that priors allow, each with its scenario.
void run_random(const RenderArguments& arguments) {
  const ScenePreset preset = *preset_of(arguments.preset);
  const InterruptScope interruptible;
  Progress progress("rendering", arguments.random, "scenes");
  nlohmann::json folders = nlohmann::json::array();
  for (int i = 1; i <= arguments.random; ++i) {
    std::string name = std::to_string(i);
    if (name.size() < 4) name.insert(0, 4 - name.size(), '0');
    const std::filesystem::path folder = std::filesystem::path(arguments.out) / name;
    const std::filesystem::path file = folder / "scenario.yaml";
    write_file_atomically(
        file, random_scenario_yaml(preset, arguments.seed, static_cast<std::uint64_t>(i)));
    if (!arguments.scenario_only)
      render(load_scenario(file), folder,
             [](std::int64_t, std::int64_t) { throw_if_interrupted(); });
    throw_if_interrupted();
    folders.push_back(folder.string());
    if (!arguments.json) std::cout << folder.string() << '\n';
    progress.update(i);
  }
  if (arguments.json) std::cout << nlohmann::json{{"folders", folders}}.dump(2) << '\n';
}

void run_render(const RenderArguments& arguments) {
  const Scenario scenario = load_scenario(arguments.scenario);
  std::vector<std::filesystem::path> read = scenario.site_files;
  read.push_back(scenario.file);
  refuse_to_replace(std::filesystem::path(arguments.out) / "site.yaml", ".yaml", read);
  const InterruptScope interruptible;
  Progress progress(
      "rendering",
      scenario.site.camera ? std::optional<std::int64_t>(frame_count(scenario)) : std::nullopt,
      "frames");
  const std::vector<std::filesystem::path> written =
      render(scenario, arguments.out, [&](std::int64_t done, std::int64_t) {
        throw_if_interrupted();
        progress.update(done);
      });
  if (arguments.json) {
    nlohmann::json result;
    for (const auto& file : written) result["files"].push_back(file.string());
    result["frames"] = scenario.site.camera ? frame_count(scenario) : 0;
    result["vehicles"] = scenario.vehicles.size();
    std::cout << result.dump(2) << '\n';
  } else {
    for (const auto& file : written) std::cout << file.string() << '\n';
  }
}

}  // namespace

void add_render(CLI::App& program, int& exit_code) {
  const auto arguments = std::make_shared<RenderArguments>();
  CLI::App* command = program.add_subcommand(
      "render", "Make a clip, a photodiode trace, a site file and the truth from a scenario");
  CLI::Option* scenario =
      command->add_option("scenario", arguments->scenario, "Scenario file (YAML)");
  command->add_option("--out,-o", arguments->out, "Folder for the files; made where missing")
      ->required();
  CLI::Option* random =
      command->add_option("--random", arguments->random, "Make this many random scenes instead")
          ->check(CLI::Range(1, 100'000))
          ->excludes(scenario);
  command->add_option("--seed", arguments->seed, "Of the random scenes; 1 when left out")
      ->check(CLI::NonNegativeNumber)
      ->needs(random);
  command->add_option("--preset", arguments->preset, "Their family: " + preset_names())
      ->needs(random)
      ->check([](const std::string& name) {
        return preset_of(name) ? std::string()
                               : "\"" + name + "\" is no preset; use one of: " + preset_names();
      });
  command->add_flag("--scenario-only", arguments->scenario_only, "Write their scenarios alone")
      ->needs(random);
  command->add_flag("--json", arguments->json, "List what was written as JSON");
  command->footer(
      "Example:\n  vildar render data_samples/straight/scenario.yaml --out /tmp/straight\n"
      "  vildar render --random 100 --seed 7 --preset curve --out /tmp/curves");
  command->callback([arguments, &exit_code] {
    if (arguments->random > 0)
      run_random(*arguments);
    else if (arguments->scenario.empty())
      throw CLI::RequiredError("a scenario file, or --random N");
    else
      run_render(*arguments);
    exit_code = 0;
  });
}

}  // namespace vildar
