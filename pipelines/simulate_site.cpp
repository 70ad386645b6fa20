#include "pipelines/simulate_site.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <stdexcept>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "config/site_file.h"
#include "core/error.h"
#include "core/quantity.h"
#include "core/text.h"
#include "simulate/site_plan.h"

namespace vildar {
namespace {

struct SiteArguments {
  std::filesystem::path site;
  bool json = false;
  simulate::PlanOptions options;
};

std::string padded(std::string text, std::size_t width) {
  text.resize(std::max(width, text.size()), ' ');
  return text + ' ';
}

std::string percent(double share) { return fixed_text(100.0 * share, 2) + " %"; }

std::string shares_text(const SpeedBudget& budget) {
  std::vector<std::pair<double, std::string>> shares;
  for (const auto& [name, share] : budget.scale_shares) shares.emplace_back(share, name);
  std::sort(shares.rbegin(), shares.rend());
  std::string text;
  for (const auto& [share, name] : shares)
    text += (text.empty() ? "" : ", ") + name + " " + fixed_text(100.0 * share, 0) + " %";
  return text;
}

void print_light_alone(const simulate::PlanRow& row) {
  if (row.light_alone)
    std::cout << "    photodiodes without the camera: "
              << percent(row.light_alone->std_mps / row.speed_mps)
              << ", of the time at which it passes them (a run of the trace alone)\n";
}

void print_text(const std::vector<simulate::PlanRow>& rows) {
  std::cout << padded("lane", 10) << padded("km/h", 5) << padded("seen m", 12) << padded("s", 5)
            << padded("sigma", 8) << padded("shape", 8) << padded("scale", 8)
            << padded("method", 24) << "scale from\n";
  for (const simulate::PlanRow& row : rows) {
    const VehicleResult& result = row.result;
    std::cout << padded(row.lane, 10) << padded(fixed_text(kmh_from_mps(row.speed_mps), 0), 5)
              << padded(row.from_m > row.to_m || row.to_m > row.from_m
                            ? fixed_text(row.from_m, 0) + " to " + fixed_text(row.to_m, 0)
                            : "",
                        12)
              << padded(fixed_text(row.seconds, 1), 5);
    if (result.withheld) {
      std::cout << "withheld:" << name_of(*result.withheld) << '\n';
      for (const std::string& warning : result.warnings) std::cout << "    " << warning << '\n';
      print_light_alone(row);
      continue;
    }
    const bool split = result.budget.has_value();
    std::cout << padded(percent(result.speed.std_mps / row.speed_mps), 8)
              << padded(split ? percent(result.budget->shape) : "", 8)
              << padded(split ? percent(result.budget->scale) : "", 8)
              << padded(std::string(name_of(result.method)), 24)
              << (split ? shares_text(*result.budget) : "") << '\n';
    print_light_alone(row);
  }
}

nlohmann::json json_of(const simulate::PlanRow& row) {
  const VehicleResult& result = row.result;
  nlohmann::json json{{"lane", row.lane},
                      {"speed_mps", row.speed_mps},
                      {"seen_from_m", row.from_m},
                      {"seen_to_m", row.to_m},
                      {"seen_s", row.seconds}};
  json["status"] =
      result.withheld ? "withheld:" + std::string(name_of(*result.withheld)) : "measured";
  if (!result.withheld) {
    json["speed_std_mps"] = result.speed.std_mps;
    json["method"] = name_of(result.method);
    if (result.budget) {
      json["shape"] = result.budget->shape;
      json["scale"] = result.budget->scale;
      json["scale_shares"] = result.budget->scale_shares;
    }
  }
  for (const MethodResult& method : result.methods)
    if (const auto* speed = std::get_if<SpeedEstimate>(&method.speed))
      json["methods"][std::string(name_of(method.method))] = speed->std_mps;
  if (row.light_alone) json["light_alone_std_mps"] = row.light_alone->std_mps;
  if (!result.warnings.empty()) json["warnings"] = result.warnings;
  return json;
}

void run_site(const SiteArguments& arguments) {
  std::vector<Problem> problems;
  for (const std::string& text : arguments.options.problems())
    problems.push_back({"command line", 0, "", text, "see `vildar simulate site --help`"});
  if (!problems.empty()) throw ConfigError(problems);
  const Site site = load_site(arguments.site);
  std::vector<simulate::PlanRow> rows;
  try {
    rows = simulate::plan_site(site, arguments.options);
  } catch (const std::invalid_argument& error) {
    throw ConfigError({{arguments.site.string(), 0, "", error.what(), "see docs/estimation.md"}});
  }
  if (!arguments.json) return print_text(rows);
  nlohmann::json json = nlohmann::json::array();
  for (const simulate::PlanRow& row : rows) json.push_back(json_of(row));
  std::cout << json.dump(2) << '\n';
}

}  // namespace

CLI::App* add_simulate_site(CLI::App& simulate, int& exit_code) {
  const auto arguments = std::make_shared<SiteArguments>();
  CLI::App* command = simulate.add_subcommand(
      "site", "What a site would measure: sigma of speed per lane, before anything is installed");
  simulate::PlanOptions& o = arguments->options;
  const auto option = [&](const char* name, auto& value, const char* what) {
    command->add_option(name, value, what)->capture_default_str();
  };
  command->add_option("site", arguments->site, "Site file")->required();
  command->add_flag("--json", arguments->json, "Print as JSON");
  option("--speeds-kmh", o.speeds_kmh, "Speeds to plan for");
  option("--frame-rate-hz", o.frame_rate_hz, "Frames a second");
  option("--centroid-sigma-px", o.centroid_sigma_px, "Sigma of a lamp's place in the image");
  option("--farthest-m", o.farthest_m, "Range from which a vehicle is followed");
  option("--photodiode-rate-hz", o.photodiode_rate_hz, "Samples a second");
  option("--photodiode-snr-db", o.photodiode_snr_db,
         "20 log10 of the power from 60 m over the noise of a sample");
  command->footer("Example: vildar simulate site site.yaml --speeds-kmh 50 90");
  command->callback([arguments, &exit_code] {
    run_site(*arguments);
    exit_code = 0;
  });
  return command;
}

}  // namespace vildar
