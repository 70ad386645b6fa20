#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "pipelines/commands.h"
#include "pipelines/progress.h"
#include "synth/frame_times.h"
#include "synth/render.h"

namespace vildar {
namespace {

struct RenderArguments {
  std::string scenario;
  std::string out;
  bool json = false;
};

void run_render(const RenderArguments& arguments) {
  const Scenario scenario = load_scenario(arguments.scenario);
  Progress progress("rendering", scenario.site.camera
                                     ? std::optional<std::int64_t>(frame_count(scenario))
                                     : std::nullopt);
  const std::vector<std::filesystem::path> written = render(
      scenario, arguments.out, [&](std::int64_t done, std::int64_t) { progress.update(done); });
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
  command->add_option("scenario", arguments->scenario, "Scenario file (YAML)")->required();
  command->add_option("--out,-o", arguments->out, "Folder for the files; made where missing")
      ->required();
  command->add_flag("--json", arguments->json, "List what was written as JSON");
  command->footer(
      "Example:\n  vildar render data_samples/straight/scenario.yaml --out /tmp/straight");
  command->callback([arguments, &exit_code] {
    run_render(*arguments);
    exit_code = 0;
  });
}

}  // namespace vildar
