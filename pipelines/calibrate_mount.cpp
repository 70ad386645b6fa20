#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <iostream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "calib/site/learn.h"
#include "calib/site/turned_camera.h"
#include "config/site_file.h"
#include "core/atomic_file.h"
#include "core/error.h"
#include "core/quantity.h"
#include "core/text.h"
#include "pipelines/calibration_inputs.h"
#include "pipelines/commands.h"
#include "pipelines/recorded_passes.h"
#include "pipelines/relearning.h"

namespace vildar {
namespace {

namespace fs = std::filesystem;

SiteLearning learn(const std::vector<VehicleTrack>& passes, const Site& site) {
  auto outcome = learn_site(passes, site);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) {
    constexpr std::size_t kFewest = 5;
    throw InputError(
        std::to_string(passes.size()) + " passes do not determine the site (" +
        std::string(name_of(*miss)) +
        "); at least five must fit the site file (one that turns, or whose lamps or lane it does "
        "not tell, is left out): " +
        (passes.size() < kFewest
             ? "record for longer, or give more runs"
             : "check the camera's position_m, yaw_deg and pitch_deg, the lanes and the lamps, "
               "and that the runs are of this camera (angles that are left out of the site file "
               "are learned), or give more runs"));
  }
  return std::get<SiteLearning>(std::move(outcome));
}

// In the unit of the site file's key.
double for_people(const LearnedQuantity& quantity, double value) {
  return quantity.angle ? degrees_from_radians(value) : value;
}

std::string text_of(const LearnedQuantity& quantity, const Uncertain& value) {
  return fixed_text(for_people(quantity, value.mean), 4) + " +- " +
         fixed_text(for_people(quantity, value.std), 4);
}

// A camera that was moved between two runs, or a run of another site, would be averaged into a
// pose that neither had.
void refuse_moved_camera(const std::vector<fs::path>& folders,
                         const std::vector<std::vector<VehicleTrack>>& runs, const Site& site) {
  const auto turned = turned_camera(runs, site);
  if (!turned) return;
  throw InputError(folders[turned->one].string() + " and " + folders[turned->other].string() +
                   ": by their own passes " + turned->by_one.key + " is " +
                   text_of(turned->by_one, turned->by_one.after) + " and " +
                   text_of(turned->by_other, turned->by_other.after) +
                   "; the camera was moved between these runs, or they are of different sites: "
                   "calibrate from the runs of one mounting");
}

// So far from the file that either is wrong: what is not learned, as a lens that the file does not
// describe, bends what is, and speeds would be worse for it.
void refuse_what_denies_the_file(const SiteLearning& learning, const fs::path& site_file) {
  const auto most = learning.denied();
  if (!most) return;
  throw InputError(
      site_file.string() + ": " + most->key + " is taken as " + text_of(*most, most->before) +
      ", which the passes put " + fixed_text(std::abs(most->strain), 1) + " sigmas off, at " +
      text_of(*most, most->after) +
      "; nothing is written: a lens that the file does not describe does the same, so "
      "measure focal_px, principal_px and distortion with a calibration board; else "
      "measure this, or state the std that it is known to (not that which was learned, "
      "where the file is a learned one), and calibrate again");
}

// The runs of which most passes were left out, though of the others most were not: of another
// camera, or another mounting.
std::string odd_runs(const SiteLearning& learning, const std::vector<fs::path>& folders,
                     const std::vector<std::size_t>& passes_of_run) {
  constexpr std::size_t kFewest = 5;
  constexpr double kMost = 0.5;
  std::string odd;
  std::size_t first = 0, sound_runs = 0;
  for (std::size_t run = 0; run < folders.size(); ++run) {
    const std::size_t all = passes_of_run[run];
    const auto took_part = std::ranges::count_if(
        learning.took_part, [&](std::size_t pass) { return pass >= first && pass < first + all; });
    first += all;
    if (static_cast<double>(took_part) >= kMost * static_cast<double>(all))
      ++sound_runs;
    else if (all >= kFewest)
      odd += (odd.empty() ? "" : ", ") + folders[run].string() + " (" + std::to_string(took_part) +
             " of " + std::to_string(all) + " passes fit)";
  }
  return sound_runs > 0 ? odd : "";
}

// What a reader should know before the new file is used.
std::vector<std::string> warnings_of(const SiteLearning& learning,
                                     const std::vector<fs::path>& folders,
                                     const std::vector<std::size_t>& passes_of_run) {
  constexpr double kManyLeftOut = 0.25;
  std::vector<std::string> found;
  if (learning.strains_the_file()) {
    std::vector<LearnedQuantity> strained = learning.quantities;
    std::ranges::sort(strained, std::ranges::greater(),
                      [](const LearnedQuantity& one) { return std::abs(one.strain); });
    strained.resize(std::min<std::size_t>(strained.size(), 3));
    std::string told;
    for (const LearnedQuantity& one : strained)
      told += (told.empty() ? "" : ", ") + one.key + " by " + fixed_text(std::abs(one.strain), 1);
    found.push_back(
        "the passes do not agree with what the site file states (sigmas: " + told +
        "); something in it is off or called too sure, maybe what is not learned (position_m, "
        "focal_px, lens), and what was learned is off with it: correct it and calibrate again");
  }
  int left_out = 0;
  for (const auto& [reason, count] : learning.left_out) left_out += count;
  const int all = learning.passes() + left_out;
  if (const std::string odd = odd_runs(learning, folders, passes_of_run); !odd.empty())
    found.push_back(odd +
                    ": unlike the other runs; of another camera, or was it moved? Calibrate "
                    "from the runs of one mounting");
  if (left_out > kManyLeftOut * all)
    found.push_back(std::to_string(left_out) + " of " + std::to_string(all) +
                    " passes were left out; where that many do not fit, those that do are no fair "
                    "sample: check the position_m, lanes and lamps of the site file");
  return found;
}

std::vector<LearnedFrom::Quantity> learned_of(const SiteLearning& learning) {
  std::vector<LearnedFrom::Quantity> quantities;
  for (const LearnedQuantity& quantity : learning.quantities)
    if (quantity.after != quantity.before)
      quantities.push_back(
          {quantity.key,
           {for_people(quantity, quantity.before.mean), for_people(quantity, quantity.before.std)},
           *said_of(quantity.key, learning.site)});
  return quantities;
}

std::string text_report(const SiteLearning& learning) {
  std::string out = std::to_string(learning.passes()) + " passes";
  for (const auto& [reason, count] : learning.left_out)
    out += "; left out as " + reason + ": " + std::to_string(count);
  out += "\n";
  for (const LearnedQuantity& quantity : learning.quantities) {
    out += quantity.key + ": " + text_of(quantity, quantity.before) + " -> " +
           text_of(quantity, quantity.after) + "  (" + std::to_string(quantity.passes) +
           " passes; mean +- " + fixed_text(for_people(quantity, quantity.mean_std), 4) +
           ", vehicles differ by " + fixed_text(for_people(quantity, quantity.spread), 4) +
           "; sigma " + fixed_text(quantity.before.std / quantity.after.std, 2) +
           " times smaller)\n";
  }
  out += "speed of a vehicle: sigma " + percent_text(learning.speed_std_before) + " -> " +
         percent_text(learning.speed_std_after) + " (median)\n";
  out += "common to all speeds of the site: " + percent_text(learning.common_scale_std_before) +
         " -> " + percent_text(learning.common_scale_std) +
         "; bearings do not tell the scale of the lengths, so this rests on the site file: survey "
         "the height of the camera over the lamps, or a lane, to lower it\n";
  if (!learning.settled())
    out += "not settled: the last round still turned the camera by " +
           fixed_text(degrees_from_radians(learning.last_turn_rad), 4) +
           " degrees; calibrate again from the improved site file\n";
  return out;
}

std::string json_report(const SiteLearning& learning, const std::vector<std::string>& warnings) {
  nlohmann::ordered_json report;
  report["passes"] = learning.passes();
  report["left_out"] = learning.left_out;
  for (const LearnedQuantity& quantity : learning.quantities) {
    const auto uncertain = [&](const Uncertain& value) {
      return nlohmann::ordered_json{{"mean", for_people(quantity, value.mean)},
                                    {"std", for_people(quantity, value.std)}};
    };
    report["quantities"][quantity.key] = {{"before", uncertain(quantity.before)},
                                          {"after", uncertain(quantity.after)},
                                          {"mean_std", for_people(quantity, quantity.mean_std)},
                                          {"spread", for_people(quantity, quantity.spread)},
                                          {"strain", quantity.strain},
                                          {"passes", quantity.passes}};
  }
  report["speed_relative_std"] = {{"before", learning.speed_std_before},
                                  {"after", learning.speed_std_after}};
  report["common_scale_relative_std"] = {{"before", learning.common_scale_std_before},
                                         {"after", learning.common_scale_std}};
  report["settled"] = learning.settled();
  report["warnings"] = warnings;
  return report.dump(2) + "\n";
}

void calibrate_mount(const RunsArguments& arguments) {
  const Site given = load_fixed_site(arguments.site);
  std::vector<std::string> warnings;
  const Site site = before_learning(given, given.learned.mount, warnings);
  refuse_repeated(arguments.runs);
  std::vector<std::vector<VehicleTrack>> runs;
  for (const fs::path& folder : arguments.runs) {
    std::vector<VehicleTrack>& run = runs.emplace_back();
    for (RecordedPass& pass : read_recorded_passes(folder, *site.camera))
      if (pass.sound) run.push_back(std::move(pass.track));
  }
  refuse_same_passes(arguments.runs, runs);
  if (runs.size() > 1) refuse_moved_camera(arguments.runs, runs, site);
  std::vector<VehicleTrack> passes;
  std::vector<std::size_t> passes_of_run;
  for (std::vector<VehicleTrack>& run : runs) {
    passes_of_run.push_back(run.size());
    std::ranges::move(run, std::back_inserter(passes));
  }
  const SiteLearning learning = learn(passes, site);
  refuse_what_denies_the_file(learning, arguments.site);
  Site learned = learning.site;
  learned.learned.mount = {learned_of(learning), clips_of(arguments.runs)};
  write_file_atomically(arguments.out, effective_site_yaml(learned));
  std::ranges::move(warnings_of(learning, arguments.runs, passes_of_run),
                    std::back_inserter(warnings));
  warn_of_forgotten(given.learned.mount, learned.learned.mount->clips, warnings);
  for (const std::string& warning : warnings) std::cerr << "warning: " << warning << "\n";
  std::cout << (arguments.json ? json_report(learning, warnings) : text_report(learning))
            << std::flush;
}

}  // namespace

void add_calibrate_mount(CLI::App& calibrate, int& exit_code) {
  CLI::App* command = calibrate.add_subcommand(
      "mount", "Camera angles, lamps and lanes of a site, learned from the passes of its runs");
  command->footer(
      "Example:\n"
      "  vildar run monday.mp4 --site site.yaml --out monday\n"
      "  vildar run tuesday.mp4 --site site.yaml --out tuesday\n"
      "  vildar calibrate mount monday tuesday --site site.yaml --out site_learned.yaml\n\n"
      "What the site file gives as {mean, std} is learned: yaw, pitch and roll of the camera (and "
      "its\n"
      "focal length, with a focal_std_px), height and separation of lamps, the line driven in "
      "each\n"
      "lane. A plain number is known and stays. The new site file holds the new means and "
      "standard\n"
      "deviations; the report tells each before and after, and what no pass can tell. See\n"
      "docs/calibration.md.\n"
      "Exit codes: 0 done; 2 usage or site file; 3 a run cannot be read, too few passes, a camera\n"
      "that was moved between runs, or passes that deny the site file; 5 the output cannot be "
      "written; 1 internal error.");
  add_runs_arguments(*command, calibrate_mount, exit_code);
}

}  // namespace vildar
