#include <cstdio>
#include <iostream>
#include <memory>

#include <CLI/CLI.hpp>

#include "core/quantity.h"
#include "core/text.h"
#include "pipelines/commands.h"
#include "pipelines/run_pipeline.h"
#include "pipelines/terminal_warnings.h"

namespace vildar {
namespace {

constexpr int kDoneButDamaged = 4;

std::string speed_text(const VehicleResult& vehicle) {
  if (vehicle.withheld) return "withheld: " + std::string(name_of(*vehicle.withheld));
  const SpeedEstimate& speed = vehicle.speed;
  return fixed_text(kmh_from_mps(speed.speed_mps), 1) + " +- " +
         fixed_text(kmh_from_mps(speed.std_mps), 1) +
         " km/h (95 %: " + fixed_text(kmh_from_mps(speed.lo95_mps), 1) + " to " +
         fixed_text(kmh_from_mps(speed.hi95_mps), 1) + ")";
}

void print_table(const RunOutcome& outcome) {
  if (outcome.vehicles.empty()) std::cout << "no vehicle seen\n";
  for (const VehicleResult& vehicle : outcome.vehicles) {
    std::string lane = vehicle.lane.empty() ? std::string("-") : vehicle.lane;
    std::printf("vehicle %-4d %-9s lane %-8s %7s to %-7s s  %s\n", vehicle.track_id,
                std::string(name_of(vehicle.direction)).c_str(), lane.c_str(),
                fixed_text(vehicle.t_first_s, 2).c_str(), fixed_text(vehicle.t_last_s, 2).c_str(),
                speed_text(vehicle).c_str());
  }
  std::cout << std::flush;
}

}  // namespace

void add_run(CLI::App& program, int& exit_code) {
  auto options = std::make_shared<RunOptions>();
  auto json = std::make_shared<bool>(false);
  CLI::App* command = program.add_subcommand(
      "run", "Measure the speeds in a recorded clip, a photodiode trace, or both");
  command->footer(
      "Examples:\n"
      "  vildar run clip.mp4 --site site.yaml --out results\n"
      "  vildar run clip.mp4 --photodiode trace.csv --site site.yaml --out results --annotate\n"
      "  vildar run --photodiode trace.csv --site site.yaml --out results\n\n"
      "Writes speeds.csv, methods.csv, tracks.csv, run.json and report.html to the output folder.\n"
      "Exit codes: 0 done; 2 usage or site file; 3 input unreadable; 4 done, but an input was\n"
      "damaged; 5 output cannot be written; 1 internal error; 130 or 143 interrupted.");
  command->add_option("clip", options->clip, "Video of any container and codec that FFmpeg reads");
  command->add_option("--photodiode", options->photodiode, "Photodiode trace (CSV, WAV or FLAC)");
  command->add_option("--site", options->site, "Site file (YAML)")->required();
  command->add_option("--out", options->out, "Folder for the results; made if missing")->required();
  command->add_option("--frame-rate", options->clip_options.frame_rate_hz,
                      "Frames per second to assume in place of the clip's own time stamps");
  command->add_option("--threads", options->clip_options.decoder_threads, "Decoder threads")
      ->capture_default_str();
  command->add_flag(
      "--fast", options->clip_options.skip_loop_filter,
      "Skip the H.264 loop filter: faster, lamps shift by a little (docs/results.md)");
  command->add_flag("--annotate", options->annotate, "Also write annotated.mp4");
  command->add_flag("--blobs", options->blobs, "Also write blobs.csv, every light of every frame");
  command->add_flag("--json", *json, "Print run.json on standard output in place of the table");
  command->callback([options, json, &exit_code] {
    const RunOutcome outcome = run_pipeline(*options);
    for (const std::string& warning : terminal_warnings(outcome.summary.warnings))
      std::cerr << "vildar: warning: " << warning << '\n';
    if (*json) {
      std::cout << run_json_text(outcome.summary, outcome.vehicles);
    } else {
      print_table(outcome);
    }
    exit_code = outcome.summary.damaged ? kDoneButDamaged : 0;
  });
}

}  // namespace vildar
