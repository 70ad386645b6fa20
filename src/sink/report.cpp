#include "sink/report.h"

#include <algorithm>

#include "sink/html.h"
#include "sink/report_parts.h"
#include "sink/report_style.h"
#include "sink/svg_plots.h"

namespace vildar {
namespace {

// Beyond this many, vehicles are folded so that the page stays an overview.
constexpr std::size_t kVehiclesUnfolded = 6;

std::string speeds_section(const RunSummary& summary, std::span<const VehicleResult> vehicles) {
  const std::string svg = svg_speed_histogram(vehicles, summary.speed_limit_mps);
  if (svg.empty()) return {};
  return "<h2>Speeds</h2><div class=\"scroll\"><figure>" + svg +
         "</figure></div><p class=\"soft\">A vehicle counts in each bar by the probability that "
         "its speed lies there. "
         "Dots and lines below the axis: speeds and their 95 % intervals.</p>";
}

}  // namespace

std::string report_text(const RunSummary& summary, std::span<const VehicleResult> vehicles,
                        std::span<const TrackPlot> plots) {
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>" +
      escaped(report_title(summary)) + " · vildar</title><style>" + std::string(kReportStyle) +
      "</style></head><body><main>\n";
  html += report_head(summary, vehicles) + report_warnings(summary) + '\n';
  html += report_vehicles(vehicles) + '\n' + speeds_section(summary, vehicles) + '\n' +
          report_methods(vehicles) + '\n';
  if (!vehicles.empty()) html += "<h2>Each vehicle</h2>\n";
  for (const VehicleResult& vehicle : vehicles) {
    const auto plot = std::find_if(plots.begin(), plots.end(), [&](const TrackPlot& candidate) {
      return candidate.track_id == vehicle.track_id;
    });
    html += report_vehicle(vehicle, plot == plots.end() ? nullptr : &*plot,
                           vehicles.size() <= kVehiclesUnfolded) +
            '\n';
  }
  html += report_making(summary);
  html +=
      "\n<footer><p>± is one standard deviation. The 95 % interval is where the speed lies with 95 "
      "% probability, given "
      "the site file. A withheld speed is one that the data do not determine: none is better than "
      "a wrong one.</p>"
      "</footer></main></body></html>\n";
  return html;
}

AtomicFile write_report(const std::filesystem::path& path, const RunSummary& summary,
                        std::span<const VehicleResult> vehicles, std::span<const TrackPlot> plots) {
  return finished_file(path, report_text(summary, vehicles, plots));
}

}  // namespace vildar
