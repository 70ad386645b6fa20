#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <list>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "calib/photodiode/learn.h"
#include "calib/photodiode/learn_clock.h"
#include "config/site_file.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/text.h"
#include "pipelines/calibration_inputs.h"
#include "pipelines/commands.h"
#include "pipelines/recorded_passes.h"
#include "pipelines/relearning.h"
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

/// A run's traces and the vehicles that shine on them.
struct LitRun {
  std::vector<PowerTrace> traces;
  std::vector<LitVehicle> lit;
  std::vector<bool> sound;
  std::vector<VehicleTrack> tracks;
  std::vector<OfferedPower> offered;  ///< LitPass points into these
};

LitRun read_run(const fs::path& run, const fs::path& site_file, const Site& site) {
  RunOptions options;
  options.site = site_file;
  options.photodiode = trace_of(run);
  RunSummary summary;
  LitRun lit_run;
  lit_run.traces = read_traces(options, site, summary);
  for (const std::string& warning : summary.warnings) std::cerr << "warning: " << warning << "\n";
  for (const RecordedPass& pass : read_recorded_passes(run, *site.camera)) {
    LitVehicle& vehicle = lit_run.lit.emplace_back(lit_vehicle(pass.track, site));
    if (!pass.sound) vehicle.way.reset();  // it shines, but how is not known
    lit_run.sound.push_back(vehicle.way && !vehicle.receding);
    lit_run.tracks.push_back(pass.track);
  }
  return lit_run;
}

std::vector<TimedPass> timed_passes(const std::list<LitRun>& runs) {
  std::vector<TimedPass> passes;
  for (const LitRun& run : runs)
    for (std::size_t v = 0; v < run.lit.size(); ++v)
      if (run.sound[v]) passes.push_back({*run.lit[v].way, run.traces});
  return passes;
}

std::vector<LitPass> lit_passes(std::list<LitRun>& runs, const Site& site) {
  std::vector<LitPass> passes;
  for (LitRun& run : runs) {
    run.offered.reserve(run.lit.size());
    for (std::size_t v = 0; v < run.lit.size(); ++v) {
      if (!run.sound[v]) continue;
      run.offered.push_back(offer_power(run.lit, v, site, run.traces));
      passes.push_back({*run.lit[v].way, run.offered.back().power});
    }
  }
  return passes;
}

/// What was learned; of what the site file calls known nothing is.
struct Learning {
  std::size_t passes = 0;  ///< that the camera followed
  std::optional<ClockLearning> clock;
  std::optional<GainLearning> gains;

  const Site& site() const { return gains ? gains->site : clock->site; }
  bool empty() const {
    return !(clock && clock->clock.learned) && !(gains && gains->passes >= kFewestGainPasses);
  }
};

std::string list_of(const std::map<std::string, int>& counts) {
  std::string out;
  for (const auto& [reason, count] : counts)
    out += "; left out as " + reason + ": " + std::to_string(count);
  return out;
}

Learning learn(std::list<LitRun>& runs, const Site& site, const fs::path& site_file) {
  Learning learning;
  const std::vector<TimedPass> timed = timed_passes(runs);
  learning.passes = timed.size();
  auto clock = learn_clock(timed, site);
  if (auto* found = std::get_if<ClockLearning>(&clock)) learning.clock = std::move(*found);
  if (const Miss* miss = std::get_if<Miss>(&clock); miss && *miss == Miss::outside_model)
    std::cerr << "warning: " << site_file.string()
              << ": photodiodes differ in time_offset_s, which is one for all that share a trace "
                 "file; it is not learned, so write one for all\n";
  const Site& timed_site = learning.clock ? learning.clock->site : site;
  auto gains = learn_gains(lit_passes(runs, timed_site), timed_site);
  if (auto* found = std::get_if<GainLearning>(&gains)) learning.gains = std::move(*found);
  if (!learning.clock && !learning.gains)
    throw ConfigError({{site_file.string(), 0, "photodiodes",
                        "neither time_offset_s nor a gain_ratio after the first has a std, so "
                        "there is nothing to learn",
                        "write what is not known well as {mean, std}"}});
  if (learning.empty()) {
    std::string fault = std::to_string(learning.passes) + " passes that the camera followed";
    if (learning.clock)
      fault += ", " + std::to_string(learning.clock->clock.passes) +
               " of them seen to leave a photodiode's view" + list_of(learning.clock->left_out);
    if (learning.gains)
      fault += ", " + std::to_string(learning.gains->passes) + " of them with power that fits" +
               list_of(learning.gains->left_out);
    fault += "; at least five are needed: record for longer, or give more runs";
    if (learning.clock)
      fault +=
          "; write time_offset_s with a larger std where the clocks may be further apart, and give "
          "runs together only if they share one";
    throw InputError(fault);
  }
  return learning;
}

std::string text_of(const Uncertain& value) {
  return fixed_text(value.mean, 4) + " +- " + fixed_text(value.std, 4);
}

/// What became of a key of the site file.
struct Change {
  bool learned = false;
  Uncertain before, after;
  int passes = 0;
  double mean_std = 0.0, spread = 0.0;
};

Change change_of(const LearnedClock& clock) {
  return {clock.learned, clock.before, clock.after, clock.passes, clock.mean_std_s, clock.spread_s};
}

Change change_of(const LearnedGain& gain) {
  return {gain.passes >= kFewestGainPasses,
          gain.before,
          gain.after,
          gain.passes,
          gain.mean_std,
          gain.spread};
}

std::string text_of(const std::string& key, const Change& change) {
  if (!change.learned)
    return key + ": " + text_of(change.before) + " stays (" + std::to_string(change.passes) +
           " passes tell of it)\n";
  return key + ": " + text_of(change.before) + " -> " + text_of(change.after) + "  (" +
         std::to_string(change.passes) + " passes; mean +- " + fixed_text(change.mean_std, 4) +
         ", passes differ by " + fixed_text(change.spread, 4) + "; sigma " +
         fixed_text(change.before.std / change.after.std, 2) + " times smaller)\n";
}

// What a reader should know before the new file is used.
std::vector<std::string> warnings_of(const Learning& learning) {
  constexpr double kFarClock = 2.5, kFarGain = 3.5;  // sigmas; no clock is looked for beyond 3
  const auto strain = [](const Change& change) {
    return std::abs(change.after.mean - change.before.mean) / change.before.std;
  };
  std::vector<std::string> found;
  if (learning.clock) {
    const Change clock = change_of(learning.clock->clock);
    if (clock.learned && strain(clock) > kFarClock)
      found.push_back("time_offset_s lies " + fixed_text(strain(clock), 1) +
                      " of its stated sigmas from the site file: check the photodiodes' yaw_deg, "
                      "half_field_of_view_deg and position_m, from which follows when lamps leave "
                      "their view, or state a larger std");
  }
  if (!learning.gains) return found;
  for (const LearnedGain& gain : learning.gains->gains) {
    const Change change = change_of(gain);
    if (!change.learned) continue;
    const bool far = strain(change) > kFarGain;
    if (far || gain.differs)
      found.push_back(gain.key +
                      (far ? " lies " + fixed_text(strain(change), 1) +
                                 " of its stated sigmas from the site file"
                           : " differs between passes by " + fixed_text(change.spread, 3) +
                                 ", more than the site file states of it") +
                      ": check the photodiodes' position_m, yaw_deg and pitch_deg, or state a "
                      "larger std");
  }
  return found;
}

std::vector<LearnedFrom::Quantity> learned_of(const Learning& learning) {
  std::vector<LearnedFrom::Quantity> quantities;
  const auto add = [&](const std::string& key, const Change& change) {
    if (change.learned) quantities.push_back({key, change.before, *said_of(key, learning.site())});
  };
  if (learning.clock) add("time_offset_s", change_of(learning.clock->clock));
  if (learning.gains)
    for (const LearnedGain& gain : learning.gains->gains) add(gain.key, change_of(gain));
  return quantities;
}

std::string text_report(const Learning& learning) {
  std::string out = std::to_string(learning.passes) + " passes that the camera followed\n";
  if (learning.clock) {
    const LearnedClock& clock = learning.clock->clock;
    out += "seen to leave a photodiode's view: " + std::to_string(clock.passes) +
           list_of(learning.clock->left_out) + "\n" + text_of("time_offset_s", change_of(clock));
  }
  if (!learning.gains) return out;
  out += "with power that fits: " + std::to_string(learning.gains->passes) +
         list_of(learning.gains->left_out) + "\n";
  for (const LearnedGain& gain : learning.gains->gains) out += text_of(gain.key, change_of(gain));
  if (learning.gains->passes > 0)
    out += "speed of a vehicle from camera and photodiodes: sigma " +
           percent_text(learning.gains->speed_std_before) + " -> " +
           percent_text(learning.gains->speed_std_after) + " (median)\n";
  return out;
}

nlohmann::ordered_json json_of(const Change& change) {
  const auto uncertain = [](const Uncertain& value) {
    return nlohmann::ordered_json{{"mean", value.mean}, {"std", value.std}};
  };
  return {{"learned", change.learned},        {"before", uncertain(change.before)},
          {"after", uncertain(change.after)}, {"mean_std", change.mean_std},
          {"spread", change.spread},          {"passes", change.passes}};
}

std::string json_report(const Learning& learning, const std::vector<std::string>& warnings) {
  nlohmann::ordered_json report;
  report["followed"] = learning.passes;
  if (learning.clock) {
    const LearnedClock& clock = learning.clock->clock;
    report["left_out_of_time_offset"] = learning.clock->left_out;
    report["quantities"]["time_offset_s"] = json_of(change_of(clock));
  }
  if (learning.gains) {
    report["passes"] = learning.gains->passes;
    report["left_out"] = learning.gains->left_out;
    for (const LearnedGain& gain : learning.gains->gains)
      report["quantities"][gain.key] = json_of(change_of(gain));
    report["speed_relative_std"] = {{"before", learning.gains->speed_std_before},
                                    {"after", learning.gains->speed_std_after}};
  }
  report["warnings"] = warnings;
  return report.dump(2) + "\n";
}

void calibrate_photodiode(const RunsArguments& arguments) {
  const Site given = load_fixed_site(arguments.site);
  std::vector<std::string> warnings;
  const Site site = before_learning(given, given.learned.photodiode, warnings);
  if (site.photodiodes.empty())
    throw ConfigError({{arguments.site.string(), 0, "", "the site has no photodiode",
                        "add a `photodiodes:` section"}});
  refuse_repeated(arguments.runs);
  std::list<LitRun> runs;
  for (const fs::path& run : arguments.runs) runs.push_back(read_run(run, arguments.site, site));
  std::vector<std::vector<VehicleTrack>> tracks;
  for (LitRun& run : runs) tracks.push_back(std::move(run.tracks));
  refuse_same_passes(arguments.runs, tracks);
  const Learning learning = learn(runs, site, arguments.site);
  Site learned = learning.site();
  learned.learned.photodiode = {learned_of(learning), clips_of(arguments.runs)};
  write_file_atomically(arguments.out, effective_site_yaml(learned));
  std::ranges::move(warnings_of(learning), std::back_inserter(warnings));
  warn_of_forgotten(given.learned.photodiode, learned.learned.photodiode->clips, warnings);
  for (const std::string& warning : warnings) std::cerr << "warning: " << warning << "\n";
  std::cout << (arguments.json ? json_report(learning, warnings) : text_report(learning))
            << std::flush;
}

}  // namespace

void add_calibrate_photodiode(CLI::App& calibrate, int& exit_code) {
  CLI::App* command = calibrate.add_subcommand(
      "photodiode",
      "Clock and gains of photodiodes beside a camera, learned from the passes of runs");
  command->footer(
      "Example:\n"
      "  vildar run night.mp4 --photodiode night.csv --site site.yaml --out night\n"
      "  vildar calibrate photodiode night --site site.yaml --out site_lit.yaml\n\n"
      "What the site file gives as {mean, std} is learned: `gain_ratio`, the gain of a photodiode\n"
      "relative to the first, and `time_offset_s`, from the moments at which lamps leave a\n"
      "photodiode's field of view. A plain number is known and stays. The runs' photodiode traces\n"
      "are read again. See docs/calibration.md.\n"
      "Exit codes: 0 done; 2 usage or site file; 3 a run cannot be read, or too few passes; 5 the\n"
      "output cannot be written; 1 internal error.");
  add_runs_arguments(*command, calibrate_photodiode, exit_code);
}

}  // namespace vildar
