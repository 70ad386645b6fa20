#include <filesystem>
#include <fstream>
#include <iostream>
#include <list>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "calib/photodiode/learn.h"
#include "config/site_file.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/text.h"
#include "pipelines/calibration_inputs.h"
#include "pipelines/commands.h"
#include "pipelines/recorded_passes.h"
#include "pipelines/run_traces.h"
#include "pipelines/vehicle_power.h"

namespace vildar {
namespace {

namespace fs = std::filesystem;

std::string text_at(const nlohmann::json& json, const char* key) {
  if (!json.is_object()) return {};
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
}

/// The photodiode trace that a run was given, from its run.json.
fs::path trace_of(const fs::path& run) {
  const fs::path file = run / "run.json";
  const auto fail = [&](const std::string& fault) -> void {
    throw InputError(file.string() + ": " + fault);
  };
  std::ifstream stream(file);
  if (!stream) fail("cannot be opened; give a folder that `vildar run` wrote");
  const nlohmann::json json = nlohmann::json::parse(stream, nullptr, false);
  if (!json.is_object() || !json.contains("inputs") || !json["inputs"].is_array())
    fail("is not the run.json of a run; run the clip again");
  for (const nlohmann::json& input : json["inputs"]) {
    if (text_at(input, "role") != "photodiode") continue;
    const fs::path trace = text_at(input, "path");
    if (!fs::exists(trace))
      fail("its photodiode trace " + trace.string() +
           " is not there; calibrate from the folder in which the run was started, or run again");
    if (describe_input("photodiode", trace).sha256 != text_at(input, "sha256"))
      fail("its photodiode trace " + trace.string() +
           " is another one than the run was given; run the clip again");
    return trace;
  }
  fail("the run was given no photodiode trace; run the clip again with --photodiode");
  return {};
}

/// What a run's passes lie in: `passes` points into the rest.
struct LitRun {
  std::vector<PowerTrace> traces;
  std::vector<OfferedPower> offered;
};

void read_run(const fs::path& run, const fs::path& site_file, const Site& site, LitRun& lit_run,
              std::vector<LitPass>& passes) {
  RunOptions options;
  options.site = site_file;
  options.photodiode = trace_of(run);
  RunSummary summary;
  lit_run.traces = read_traces(options, site, summary);
  for (const std::string& warning : summary.warnings) std::cerr << "warning: " << warning << "\n";
  std::vector<LitVehicle> lit;
  std::vector<bool> sound;
  for (const RecordedPass& pass : read_recorded_passes(run, *site.camera)) {
    if (pass.track.kind != LampKind::headlamp) continue;
    lit.push_back(lit_vehicle(pass.track, site));
    sound.push_back(pass.sound && lit.back().way);
    if (!sound.back()) lit.back().way.reset();  // it shines, but how is not known
  }
  lit_run.offered.reserve(lit.size());
  for (std::size_t v = 0; v < lit.size(); ++v) {
    if (!sound[v]) continue;
    lit_run.offered.push_back(offer_power(lit, v, site, lit_run.traces));
    passes.push_back({*lit[v].way, lit_run.offered.back().power});
  }
}

std::string list_of(const std::map<std::string, int>& counts) {
  std::string out;
  for (const auto& [reason, count] : counts)
    out += "; left out as " + reason + ": " + std::to_string(count);
  return out;
}

GainLearning learn(std::span<const LitPass> passes, const Site& site, const fs::path& site_file) {
  auto outcome = learn_gains(passes, site);
  auto* learning = std::get_if<GainLearning>(&outcome);
  if (learning == nullptr)
    throw ConfigError({{site_file.string(), 0, "photodiodes",
                        "no gain_ratio after the first has a std, so there is nothing to learn",
                        "write one that is not known well as {mean, std}"}});
  if (learning->passes < kFewestGainPasses)
    throw InputError(std::to_string(passes.size()) + " passes that the camera followed, " +
                     std::to_string(learning->passes) + " of them with power that fits" +
                     list_of(learning->left_out) +
                     "; at least five are needed: record for longer, or give more runs");
  return std::move(*learning);
}

std::string text_of(const Uncertain& value) {
  return fixed_text(value.mean, 4) + " +- " + fixed_text(value.std, 4);
}

std::string text_report(const GainLearning& learning) {
  std::string out = std::to_string(learning.passes) + " passes" + list_of(learning.left_out) + "\n";
  for (const LearnedGain& gain : learning.gains)
    out += gain.key + ": " + text_of(gain.before) + " -> " + text_of(gain.after) + "  (" +
           std::to_string(gain.passes) + " passes; mean +- " + fixed_text(gain.mean_std, 4) +
           ", passes differ by " + fixed_text(gain.spread, 4) + "; sigma " +
           fixed_text(gain.before.std / gain.after.std, 2) + " times smaller)\n";
  out += "speed of a vehicle from camera and photodiodes: sigma " +
         percent_text(learning.speed_std_before) + " -> " + percent_text(learning.speed_std_after) +
         " (median)\n";
  return out;
}

std::string json_report(const GainLearning& learning) {
  nlohmann::ordered_json report;
  report["passes"] = learning.passes;
  report["left_out"] = learning.left_out;
  const auto uncertain = [](const Uncertain& value) {
    return nlohmann::ordered_json{{"mean", value.mean}, {"std", value.std}};
  };
  for (const LearnedGain& gain : learning.gains)
    report["quantities"][gain.key] = {{"before", uncertain(gain.before)},
                                      {"after", uncertain(gain.after)},
                                      {"mean_std", gain.mean_std},
                                      {"spread", gain.spread},
                                      {"passes", gain.passes}};
  report["speed_relative_std"] = {{"before", learning.speed_std_before},
                                  {"after", learning.speed_std_after}};
  return report.dump(2) + "\n";
}

void calibrate_photodiode(const RunsArguments& arguments) {
  const Site site = load_fixed_site(arguments.site);
  if (site.photodiodes.empty())
    throw ConfigError({{arguments.site.string(), 0, "", "the site has no photodiode",
                        "add a `photodiodes:` section"}});
  refuse_repeated(arguments.runs);
  std::list<LitRun> runs;
  std::vector<LitPass> passes;
  for (const fs::path& run : arguments.runs)
    read_run(run, arguments.site, site, runs.emplace_back(), passes);
  const GainLearning learning = learn(passes, site, arguments.site);
  write_file_atomically(arguments.out, effective_site_yaml(learning.site));
  std::cout << (arguments.json ? json_report(learning) : text_report(learning)) << std::flush;
}

}  // namespace

void add_calibrate_photodiode(CLI::App& calibrate, int& exit_code) {
  CLI::App* command = calibrate.add_subcommand(
      "photodiode", "Gains of photodiodes beside a camera, learned from the passes of runs");
  command->footer(
      "Example:\n"
      "  vildar run night.mp4 --photodiode night.csv --site site.yaml --out night\n"
      "  vildar calibrate photodiode night --site site.yaml --out site_gains.yaml\n\n"
      "What the site file gives as `gain_ratio: {mean, std}` is learned: the gain of a photodiode\n"
      "relative to the first. A plain number is known and stays. The runs' photodiode traces are\n"
      "read again. See docs/calibration.md.\n"
      "Exit codes: 0 done; 2 usage or site file; 3 a run cannot be read, or too few passes; 5 the\n"
      "output cannot be written; 1 internal error.");
  add_runs_arguments(*command, calibrate_photodiode, exit_code);
}

}  // namespace vildar
