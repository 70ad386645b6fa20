#include <CLI/CLI.hpp>

#include "pipelines/commands.h"

namespace vildar {

void add_calibrate(CLI::App& program, int& exit_code) {
  CLI::App* command =
      program.add_subcommand("calibrate", "Measure what a site file states, from recordings");
  command->footer(
      "Example: vildar calibrate mount monday tuesday --site site.yaml --out site_learned.yaml");
  command->require_subcommand(1);
  add_calibrate_mount(*command, exit_code);
  add_calibrate_psf(*command, exit_code);
  add_calibrate_photodiode(*command, exit_code);
}

}  // namespace vildar
