#include <filesystem>
#include <iostream>
#include <map>
#include <memory>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "core/atomic_file.h"
#include "core/error.h"
#include "core/text.h"
#include "pipelines/commands.h"
#include "pipelines/progress.h"
#include "pipelines/simulate_site.h"
#include "simulate/experiments.h"

namespace vildar {
namespace {

struct SimulateArguments {
  std::string experiment;
  std::filesystem::path out;
  bool json = false;
  std::string snr_convention = "electrical", label = "end", cosine = "both";
  bool no_ml = false;
  simulate::Options options;
};

void check(const simulate::Options& options) {
  std::vector<Problem> problems;
  for (const std::string& text : options.problems())
    problems.push_back({"command line", 0, "", text, "see `vildar simulate --help`"});
  if (!problems.empty()) throw ConfigError(problems);
}

void print_text(const std::vector<simulate::Report>& reports) {
  for (const simulate::Report& report : reports) {
    std::cout << report.experiment << '\n';
    for (const simulate::Finding& finding : report.findings)
      std::cout << "  " << finding.what << ": " << fixed_text(finding.value, 3)
                << (finding.unit.empty() ? "" : " " + finding.unit) << '\n';
    for (const simulate::Table& table : report.tables) {
      std::cout << "  " << table.title << '\n' << simulate::csv_of(table);
    }
  }
}

void print_json(const std::vector<simulate::Report>& reports,
                const std::vector<std::filesystem::path>& written) {
  nlohmann::json result;
  for (const simulate::Report& report : reports) {
    nlohmann::json one;
    one["experiment"] = report.experiment;
    one["numbers"] = nlohmann::json::array();
    for (const simulate::Finding& finding : report.findings)
      one["numbers"].push_back(
          {{"what", finding.what}, {"value", finding.value}, {"unit", finding.unit}});
    for (const simulate::Table& table : report.tables)
      one["tables"].push_back(
          {{"name", table.name}, {"header", table.header}, {"rows", table.rows}});
    result["experiments"].push_back(one);
  }
  for (const auto& file : written) result["files"].push_back(file.string());
  std::cout << result.dump(2) << '\n';
}

void run_simulate(SimulateArguments& arguments, const std::string& settings) {
  simulate::Options& options = arguments.options;
  options.snr_kind = arguments.snr_convention == "optical" ? simulate::SnrKind::optical
                                                           : simulate::SnrKind::electrical;
  options.label = arguments.label == "start"    ? simulate::WindowLabel::start
                  : arguments.label == "centre" ? simulate::WindowLabel::centre
                                                : simulate::WindowLabel::end;
  options.with_cosine = arguments.cosine != "no";
  options.without_cosine = arguments.cosine != "yes";
  options.maximum_likelihood = !arguments.no_ml;
  check(options);

  const bool all = arguments.experiment == "all";
  std::vector<simulate::Report> reports;
  std::int64_t done = 0;
  Progress progress("simulating",
                    static_cast<std::int64_t>(all ? simulate::experiments().size() : 1),
                    "experiments");
  for (const simulate::Experiment& experiment : simulate::experiments()) {
    if (!all && experiment.name != arguments.experiment) continue;
    reports.push_back(experiment.run(options));
    progress.update(++done);
  }

  std::vector<std::filesystem::path> written;
  const auto write = [&](const std::string& name, const std::string& text) {
    written.push_back(arguments.out / name);
    write_file_atomically(written.back(), text);
  };
  for (const simulate::Report& report : reports) {
    for (const simulate::Figure& figure : report.figures) {
      write(figure.name + ".csv", simulate::csv_of(figure));
      write(figure.name + ".svg", simulate::svg_of(figure));
    }
    for (const simulate::Table& table : report.tables)
      write(table.name + ".csv", simulate::csv_of(table));
  }
  write("index.html", simulate::page_of(reports, settings));
  if (arguments.json)
    print_json(reports, written);
  else
    print_text(reports);
}

}  // namespace

void add_simulate(CLI::App& program, int& exit_code) {
  const auto arguments = std::make_shared<SimulateArguments>();
  CLI::App* command = program.add_subcommand("simulate",
                                             "Run the paper's experiments: plots, numbers and one "
                                             "page; `site`: what a site would measure");
  CLI::App* site = add_simulate_site(*command, exit_code);
  std::vector<std::string> names{"all"};
  std::string list;
  for (const simulate::Experiment& experiment : simulate::experiments()) {
    names.emplace_back(experiment.name);
    list += "\n  " + std::string(experiment.name) + ": " + std::string(experiment.summary);
  }
  simulate::Options& o = arguments->options;
  const auto option = [&](const char* name, auto& value, const char* what) {
    return command->add_option(name, value, what)->capture_default_str();
  };
  command->add_option("experiment", arguments->experiment, "Experiment by name, or all")
      ->check(CLI::IsMember(names));
  command->add_option("--out,-o", arguments->out, "Folder for CSV, SVG and index.html");
  command->add_flag("--json", arguments->json, "Print numbers and files as JSON");
  option("--trials", o.trials, "Monte Carlo trials of every point");
  option("--seed", o.seed, "Seed; the same seed gives the same numbers on any number of threads")
      ->check(CLI::NonNegativeNumber);
  option("--threads", o.threads, "Threads; 0: all");
  option("--speed-mps", o.speed_mps, "Speed, straight road");
  option("--start-range-m", o.start_range_m, "R_o, range at the start");
  option("--perpendicular-m", o.perpendicular_m, "d, distance to the line of motion");
  option("--duration-s", o.duration_s, "Estimation duration, straight road");
  option("--sample-period-s", o.sample_period_s, "Time between samples");
  option("--half-power-angle-deg", o.half_power_angle_deg, "Half-power angle of the lamp");
  option("--gain-db", o.gain_db, "K of the simulated channel");
  option("--path-loss-exponent", o.path_loss_exponent, "gamma of the simulated channel");
  option("--lambertian-gain-db", o.lambertian_gain_db, "K of the Lambertian channel");
  option("--lambertian-exponent", o.lambertian_exponent, "gamma of the Lambertian channel");
  option("--snr-db", o.snr_db, "SNR of the first sample");
  option("--snr-convention", arguments->snr_convention,
         "electrical: 20 log10(P0 / sigma); optical: 10 log10")
      ->check(CLI::IsMember({"electrical", "optical"}));
  option("--cosine", arguments->cosine, "Whether the generator multiplies by cos^(n+1)(theta)")
      ->check(CLI::IsMember({"yes", "no", "both"}));
  option("--label", arguments->label, "Instant of a window that its estimate is drawn at")
      ->check(CLI::IsMember({"end", "centre", "start"}));
  option("--angular-speed-rad-per-s", o.angular_speed_rad_per_s, "w, curved road");
  option("--curve-radius-m", o.curve_radius_m, "r_c");
  option("--curve-start-deg", o.curve_start_deg, "Arc angle at the start");
  option("--curve-duration-s", o.curve_duration_s, "Estimation duration of curved-snr");
  option("--curve-lateral-m", o.curve_lateral_m, "d_o of the second reading of curved-geometry");
  option("--durations-s", o.durations_s, "Estimation durations compared");
  option("--snrs-db", o.snrs_db, "Initial SNRs compared");
  option("--speeds-mps", o.speeds_mps, "Speeds compared");
  option("--half-power-angles-deg", o.half_power_angles_deg, "Half-power angles compared");
  command->add_flag("--no-ml", arguments->no_ml, "Leave out maximum likelihood and the bounds");
  command->footer("Experiments:" + list +
                  "\n\nExamples:\n  vildar simulate all --out paper\n"
                  "  vildar simulate straight-duration --cosine yes --trials 4000 --out paper\n"
                  "  vildar simulate curved-snr --cosine no --snrs-db 20 30 --json --out paper");
  command->callback([arguments, command, site, &exit_code] {
    if (site->parsed()) return;
    if (arguments->experiment.empty()) throw CLI::RequiredError("experiment");
    if (arguments->out.empty()) throw CLI::RequiredError("--out");
    run_simulate(*arguments, command->config_to_str(true));
    exit_code = 0;
  });
}

}  // namespace vildar
