#include <algorithm>
#include <cmath>
#include <variant>

#include "core/quantity.h"
#include "core/text.h"
#include "sink/html.h"
#include "sink/report_parts.h"
#include "sink/svg_plots.h"
#include "sink/words.h"

namespace vildar {
namespace {

struct Scale {
  double low_kmh = 0.0, high_kmh = 1.0;
};

/// Common to all methods of a vehicle; an interval that dwarfs the speeds themselves is cut off.
Scale common_scale(const VehicleResult& vehicle) {
  double low_mps = 1e9, high_mps = 0.0, fastest_mps = 0.0;
  for (const MethodResult& result : vehicle.methods) {
    const auto* speed = std::get_if<SpeedEstimate>(&result.speed);
    if (speed == nullptr) continue;
    low_mps = std::min(low_mps, speed->lo95_mps);
    high_mps = std::max(high_mps, speed->hi95_mps);
    fastest_mps = std::max(fastest_mps, speed->speed_mps);
  }
  return {kmh_from_mps(std::max(0.0, low_mps)),
          kmh_from_mps(std::min(high_mps, 1.5 * fastest_mps + 1.0))};
}

std::string k_words(const std::string& k_source) {
  if (k_source == "site") return "from the site file";
  if (k_source == "bearings") return "from the bearings";
  return escaped(k_source);
}

void append_sentence(std::string& text, const std::string& sentence) {
  if (!text.empty()) text += ' ';
  text += sentence;
}

std::string method_rows(const VehicleResult& vehicle) {
  const Scale scale = common_scale(vehicle);
  std::string html;
  for (const MethodResult& result : vehicle.methods) {
    const auto* speed = std::get_if<SpeedEstimate>(&result.speed);
    const bool reported = !vehicle.withheld && result.method == vehicle.method;
    const std::string name(words_for(result.method));
    html += speed ? "<tr>" : "<tr class=\"withheld\">";
    html += table_cell("Method", "", reported ? "<b>" + name + "</b>" : name);
    if (speed) {
      html += table_cell("Speed, km/h", "number speed", speed_words_kmh(*speed));
      html += table_cell("95 % interval, km/h", "number", interval_words_kmh(*speed));
      html += table_cell("", "", svg_interval(*speed, scale.low_kmh, scale.high_kmh, reported));
    } else {
      html += table_cell("", "number", "") + table_cell("", "number", "") + table_cell("", "", "");
    }
    html += table_cell("Samples", "number", std::to_string(result.samples));
    std::string note =
        speed ? "" : std::string(escaped(sentence_for(std::get<Miss>(result.speed))));
    if (!result.k_source.empty())
      append_sentence(note, std::string("Channel gain ").append(k_words(result.k_source)) + ".");
    if (reported) append_sentence(note, "Reported.");
    html += table_cell("", "words", note) + "</tr>";
  }
  return html;
}

std::string figure(const TimePlot& plot) {
  const std::string svg = svg_time_plot(plot);
  return svg.empty() ? "" : "<figure>" + svg + "</figure>";
}

std::vector<double> scaled(const std::vector<double>& values, double factor) {
  std::vector<double> result(values);
  for (double& value : result) value *= factor;
  return result;
}

// 1 where nothing positive is there.
double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values)
    if (std::isfinite(value)) most = std::max(most, value);
  return most > 0.0 ? most : 1.0;
}

std::string plots_of(const VehicleResult& vehicle, const TrackPlot& plot) {
  std::optional<PlotMark> range_mark, speed_mark;
  if (!vehicle.withheld) {
    const SpeedEstimate& speed = vehicle.speed;
    if (vehicle.range_ref_m) range_mark = PlotMark{speed.time_s, *vehicle.range_ref_m, {}, {}};
    speed_mark = PlotMark{speed.time_s, kmh_from_mps(speed.speed_mps), kmh_from_mps(speed.lo95_mps),
                          kmh_from_mps(speed.hi95_mps)};
  }
  const std::string html = figure({"range in m", plot.t_s, plot.range_m, range_mark, true}) +
                           figure({"speed in km/h", plot.t_s,
                                   scaled(plot.speed_mps, kmh_from_mps(1.0)), speed_mark, false}) +
                           figure({"azimuth in degrees",
                                   plot.t_s,
                                   scaled(plot.azimuth_rad, degrees_from_radians(1.0)),
                                   {},
                                   false}) +
                           figure({"light received, % of its most",
                                   plot.t_s,
                                   scaled(plot.intensity, 100.0 / largest(plot.intensity)),
                                   {},
                                   true});
  return html.empty() ? "" : "<div class=\"plots\">" + html + "</div>";
}

std::string percent(double share) { return fixed_text(100.0 * share, share < 0.01 ? 2 : 1) + " %"; }

/// What the sigma is made of.
void append_budget(const VehicleResult& vehicle, std::vector<std::string>& facts) {
  if (vehicle.withheld) return;
  if (vehicle.budget) {
    std::string from;
    for (const auto& [name, share] : vehicle.budget->scale_shares) {
      std::string words = name;
      std::replace(words.begin(), words.end(), '_', ' ');
      from += (from.empty() ? "" : ", ") + words + " " + fixed_text(100.0 * share, 0) + " %";
    }
    facts.push_back("sigma: shape " + percent(vehicle.budget->shape) + ", scale " +
                    percent(vehicle.budget->scale) + (from.empty() ? "" : " (" + from + ")"));
  }
  for (const auto& [sensor, chi2] : vehicle.chi2_per_dof)
    facts.push_back("chi² per degree of freedom, " + sensor + " " + fixed_text(chi2, 2));
}

/// Numbers that have no column of their own.
std::string facts_of(const VehicleResult& vehicle) {
  std::vector<std::string> facts;
  if (vehicle.n_frames > 0) facts.push_back(std::to_string(vehicle.n_frames) + " frames");
  if (vehicle.n_pd_samples > 0)
    facts.push_back(std::to_string(vehicle.n_pd_samples) + " photodiode samples");
  if (vehicle.lateral_m)
    facts.push_back(fixed_text(std::abs(*vehicle.lateral_m), 1) + " m to the " +
                    (*vehicle.lateral_m < 0.0 ? "right" : "left") + " of the sensor's line");
  if (!vehicle.withheld && vehicle.acceleration_mps2)
    facts.push_back("acceleration " +
                    // Rounded first, so that no "-0.0" is shown.
                    fixed_text(std::round(*vehicle.acceleration_mps2 * 10.0) / 10.0 + 0.0, 1) +
                    " m/s²");
  if (!vehicle.withheld && vehicle.closing_speed_mps)
    facts.push_back("relative to the sensor " +
                    fixed_text(kmh_from_mps(*vehicle.closing_speed_mps), 1) + " km/h");
  append_budget(vehicle, facts);
  std::string words;
  for (const std::string& fact : facts) words += (words.empty() ? "" : " · ") + fact;
  return words;
}

}  // namespace

std::string report_vehicle(const VehicleResult& vehicle, const TrackPlot* plot, bool open) {
  const std::string id = std::to_string(vehicle.track_id);
  std::string html = "<details id=\"vehicle-" + id + "\"" + (open ? " open" : "") +
                     "><summary><b>#" + id + "</b>" + direction_words(vehicle.direction);
  if (!vehicle.lane.empty()) html += ", lane " + escaped(vehicle.lane);
  html += vehicle.withheld ? " · <span class=\"withheld-tag\">withheld</span>"
                           : " · <b>" + speed_words_kmh(vehicle.speed) + " km/h</b>";
  html += "</summary><div class=\"inside\">";
  if (vehicle.withheld) html += "<p>" + escaped(sentence_for(*vehicle.withheld)) + "</p>";
  for (const std::string& warning : vehicle.warnings)
    html += "<p class=\"soft\">" + escaped(warning) + "</p>";
  html += "<p class=\"soft\">" + facts_of(vehicle) + "</p>";
  if (!vehicle.methods.empty())
    html +=
        "<div class=\"scroll\"><table class=\"cards\"><thead><tr><th>Method</th><th "
        "class=\"number\">Speed, km/h</th>"
        "<th class=\"number\">95 % interval, km/h</th><th></th><th "
        "class=\"number\">Samples</th><th></th></tr></thead><tbody>" +
        method_rows(vehicle) + "</tbody></table></div>";
  if (plot != nullptr) html += plots_of(vehicle, *plot);
  return html + "</div></details>";
}

}  // namespace vildar
