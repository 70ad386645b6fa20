#include <algorithm>
#include <cmath>

#include "core/quantity.h"
#include "core/text.h"
#include "sink/html.h"
#include "sink/report_parts.h"

namespace vildar {
namespace {

constexpr std::size_t kWarningsInFull = 12;

std::string tile(const std::string& value, const std::string& name) {
  return "<li><b>" + escaped(value) + "</b><span>" + escaped(name) + "</span></li>";
}

std::string clip_words(const ClipSummary& clip) {
  std::string words =
      std::to_string(clip.width_px) + " × " + std::to_string(clip.height_px) + " px";
  if (clip.nominal_frame_rate_hz > 0.0)
    words += ", " + number_text(std::round(clip.nominal_frame_rate_hz * 100) / 100) + " frames/s";
  words += ", " + fixed_text(clip.duration_s, 1) + " s";
  if (!clip.codec.empty()) words += ", " + clip.codec;
  return words;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

std::string bullet(const std::string& text) { return "<li>" + escaped(text) + "</li>"; }

}  // namespace

std::string report_title(const RunSummary& summary) {
  for (const char* role : {"clip", "photodiode"})
    for (const InputFile& input : summary.inputs)
      if (input.role == role) return input.path.filename().string();
  return "Speeds from headlamps";
}

std::string report_head(const RunSummary& summary, std::span<const VehicleResult> vehicles) {
  std::vector<double> speeds_kmh;
  std::size_t over_limit = 0;
  for (const VehicleResult& vehicle : vehicles) {
    if (vehicle.withheld) continue;
    speeds_kmh.push_back(kmh_from_mps(vehicle.speed.speed_mps));
    if (summary.speed_limit_mps && vehicle.speed.lo95_mps > *summary.speed_limit_mps) ++over_limit;
  }
  std::string html = "<header><p class=\"brand\">vildar " + escaped(summary.version) +
                     " · speed of vehicles at night from the light of their headlamps</p><h1>" +
                     escaped(report_title(summary)) + "</h1><p class=\"soft\">";
  html += summary.clip ? escaped(clip_words(*summary.clip))
                       : "No camera: each pass before the photodiode counts as a vehicle";
  if (!summary.started.empty()) html += " · run of " + escaped(summary.started);
  html += "</p></header><ul class=\"tiles\">";
  html += tile(std::to_string(vehicles.size()),
               vehicles.size() == 1 ? "vehicle seen" : "vehicles seen");
  html += tile(std::to_string(speeds_kmh.size()), "measured");
  html += tile(std::to_string(vehicles.size() - speeds_kmh.size()), "withheld");
  if (!speeds_kmh.empty()) {
    html += tile(fixed_text(median(speeds_kmh), 1) + " km/h", "median speed");
    html += tile(fixed_text(*std::max_element(speeds_kmh.begin(), speeds_kmh.end()), 1) + " km/h",
                 "fastest");
  }
  if (summary.speed_limit_mps)
    html += tile(std::to_string(over_limit),
                 "above " + fixed_text(kmh_from_mps(*summary.speed_limit_mps), 0) +
                     " km/h with 97.5 % probability or more");
  return html + "</ul>";
}

std::string report_warnings(const RunSummary& summary) {
  if (summary.warnings.empty() && !summary.damaged) return {};
  std::string html = "<section class=\"warnings\"><h2>";
  html += summary.damaged ? "An input was damaged; what could be read was used" : "Mind this";
  html += "</h2>";
  const auto& warnings = summary.warnings;
  const std::size_t shown = std::min(warnings.size(), kWarningsInFull);
  if (shown > 0) {
    html += "<ul>";
    for (std::size_t i = 0; i < shown; ++i) html += bullet(warnings[i]);
    html += "</ul>";
  }
  if (shown < warnings.size()) {
    html += "<details><summary>" + std::to_string(warnings.size() - shown) +
            " more</summary><div class=\"inside\"><ul>";
    for (std::size_t i = shown; i < warnings.size(); ++i) html += bullet(warnings[i]);
    html += "</ul></div></details>";
  }
  return html + "</section>";
}

}  // namespace vildar
