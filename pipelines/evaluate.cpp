#include <filesystem>
#include <iostream>
#include <memory>

#include <CLI/CLI.hpp>

#include "config/site_file.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "evaluate/report.h"
#include "pipelines/commands.h"
#include "pipelines/safe_output.h"

namespace vildar {
namespace {

constexpr int kRequirementFails = 6;

struct EvaluateArguments {
  std::filesystem::path run, truth, out;
  std::vector<std::string> require;
  bool json = false;
};

// A site file beside the truth is an input like the others, not one the user wrote for this
// command.
Site site_of(const std::filesystem::path& file) {
  try {
    return load_site(file);
  } catch (const ConfigError& error) {
    throw InputError(error.what());
  }
}

// The road frame has its origin below the mast, but a site may place its camera elsewhere; and it
// alone knows of a rolling shutter.
EvaluateOptions options_of(const std::filesystem::path& truth_folder) {
  EvaluateOptions options;
  const std::filesystem::path file = truth_folder / "site.yaml";
  if (!std::filesystem::exists(file)) return options;
  const Site site = site_of(file);
  if (!site.camera) return options;
  options.camera_xy_m = {site.camera->position_m[0].mean, site.camera->position_m[1].mean};
  options.rolling_shutter_s = site.camera->rolling_shutter_s;
  options.image_height_px = site.camera->height_px;
  return options;
}

int evaluate_folders(const EvaluateArguments& arguments) {
  std::vector<Requirement> requirements;
  for (const std::string& text : arguments.require) requirements.push_back(parse_requirement(text));
  if (!arguments.out.empty())
    refuse_to_replace(arguments.out, ".json", {arguments.run, arguments.truth});
  const RunFolder run = read_run_folder(arguments.run);
  const Evaluation evaluation =
      evaluate(read_truth_folder(arguments.truth), run, options_of(arguments.truth));
  const std::vector<RequirementResult> results = check(requirements, evaluation);

  if (!arguments.out.empty())
    write_file_atomically(arguments.out, json_report(evaluation, results));
  std::cout << (arguments.json ? json_report(evaluation, results)
                               : text_report(evaluation, results))
            << std::flush;
  int exit_code = 0;
  for (const RequirementResult& result : results) {
    if (result.holds) continue;
    std::cerr << "vildar: " << to_string(result) << '\n';
    exit_code = kRequirementFails;
  }
  return exit_code;
}

}  // namespace

void add_evaluate(CLI::App& program, int& exit_code) {
  auto arguments = std::make_shared<EvaluateArguments>();
  CLI::App* command =
      program.add_subcommand("evaluate", "Score what a run wrote against known truth");
  command->footer(
      "Examples:\n"
      "  vildar evaluate results scene\n"
      "  vildar evaluate results scene --json --require 'recall>=0.95' --require 'false==0'\n"
      "  vildar evaluate results scene --out scores.json --require 'fused.max_error_kmh<=3'\n\n"
      "RUN_DIR holds speeds.csv, tracks.csv and methods.csv as `vildar run` writes them, "
      "TRUTH_DIR\n"
      "truth_vehicles.csv and truth_tracks.csv as `vildar render` writes them. A requirement names "
      "a\n"
      "metric of the JSON output, or METHOD.METRIC, with >= <= == > < and a number.\n"
      "Exit codes: 0 done, every requirement holds; 2 usage; 3 a file cannot be read or is not as "
      "it\n"
      "should be; 5 the output cannot be written; 6 a requirement does not hold; 1 internal "
      "error.");
  command->add_option("RUN_DIR", arguments->run, "Folder that a run wrote")->required();
  command->add_option("TRUTH_DIR", arguments->truth, "Folder that holds the truth")->required();
  command->add_option("--require", arguments->require,
                      "Bound to keep, e.g. 'recall>=0.95'; several");
  command->add_option("--out", arguments->out,
                      "Also write the JSON to this file, none of those that are read");
  command->add_flag("--json", arguments->json, "Print JSON in place of the tables");
  command->callback([arguments, &exit_code] { exit_code = evaluate_folders(*arguments); });
}

}  // namespace vildar
