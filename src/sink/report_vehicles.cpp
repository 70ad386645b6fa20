#include <algorithm>
#include <variant>

#include "core/quantity.h"
#include "core/text.h"
#include "sink/html.h"
#include "sink/report_parts.h"
#include "sink/words.h"

namespace vildar {
namespace {

std::string sensor_words(const VehicleResult& vehicle) {
  if (vehicle.used_camera && vehicle.used_photodiode) return "camera + photodiode";
  return vehicle.used_camera ? "camera" : vehicle.used_photodiode ? "photodiode" : "";
}

std::string track_link(int track_id) {
  const std::string id = std::to_string(track_id);
  return "<a href=\"#vehicle-" + id + "\">#" + id + "</a>";
}

std::string optional_words(std::optional<double> value, int digits) {
  return value ? fixed_text(*value, digits) : "";
}

std::string vehicle_row(const VehicleResult& vehicle) {
  std::string html = vehicle.withheld ? "<tr class=\"withheld\">" : "<tr>";
  html += table_cell("Vehicle", "", track_link(vehicle.track_id));
  html += table_cell("Direction", "short", direction_words(vehicle.direction));
  html += table_cell("Lane", "", escaped(vehicle.lane));
  html += table_cell("Seen, s", "number",
                     fixed_text(vehicle.t_first_s, 2) + " to " + fixed_text(vehicle.t_last_s, 2));
  if (vehicle.withheld) {
    // The reason takes the place of the numbers that are not given.
    html +=
        "<td class=\"words\" colspan=\"4\" data-label=\"Speed\"><span><span class=\"withheld-tag\">"
        "withheld</span> " +
        escaped(sentence_for(*vehicle.withheld)) + "</span></td>";
  } else {
    html += table_cell("Speed, km/h", "number speed", speed_words_kmh(vehicle.speed));
    html += table_cell("95 % interval, km/h", "number", interval_words_kmh(vehicle.speed));
    html += table_cell("At, s", "number", fixed_text(vehicle.speed.time_s, 2));
    html += table_cell("Range, m", "number", optional_words(vehicle.range_ref_m, 1));
  }
  html += table_cell("Sensors", "short", sensor_words(vehicle));
  html += table_cell("Method", "", vehicle.withheld ? "" : std::string(words_for(vehicle.method)));
  return html + "</tr>";
}

const MethodResult* result_of(const VehicleResult& vehicle, Method method) {
  const auto found =
      std::find_if(vehicle.methods.begin(), vehicle.methods.end(),
                   [&](const MethodResult& result) { return result.method == method; });
  return found == vehicle.methods.end() ? nullptr : &*found;
}

/// Methods that occur, in the order of the enumeration.
std::vector<Method> methods_in(std::span<const VehicleResult> vehicles) {
  std::vector<Method> methods;
  for (const VehicleResult& vehicle : vehicles)
    for (const MethodResult& result : vehicle.methods) methods.push_back(result.method);
  std::sort(methods.begin(), methods.end());
  methods.erase(std::unique(methods.begin(), methods.end()), methods.end());
  return methods;
}

std::string plain_reason(Miss miss) {
  std::string words(name_of(miss));
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

std::string method_cell(const MethodResult* result, std::string_view label) {
  if (result == nullptr) return table_cell(label, "number soft", "");
  if (const auto* speed = std::get_if<SpeedEstimate>(&result->speed))
    return table_cell(label, "number", speed_words_kmh(*speed));
  return table_cell(label, "number soft", plain_reason(std::get<Miss>(result->speed)));
}

}  // namespace

std::string report_vehicles(std::span<const VehicleResult> vehicles) {
  if (vehicles.empty()) return "<h2>Vehicles</h2><p>No vehicle was seen.</p>";
  std::string html =
      "<h2>Vehicles</h2><div class=\"scroll\"><table "
      "class=\"cards\"><thead><tr><th>Vehicle</th><th>Direction</th>"
      "<th>Lane</th><th class=\"number\">Seen, s</th><th class=\"number\">Speed, km/h</th>"
      "<th class=\"number\">95 % interval, km/h</th><th class=\"number\">At, s</th><th "
      "class=\"number\">Range, m</th>"
      "<th>Sensors</th><th>Method</th></tr></thead><tbody>";
  for (const VehicleResult& vehicle : vehicles) html += vehicle_row(vehicle);
  return html + "</tbody></table></div>";
}

std::string report_methods(std::span<const VehicleResult> vehicles) {
  const std::vector<Method> methods = methods_in(vehicles);
  if (methods.empty()) return {};
  std::string html =
      "<h2>Methods side by side</h2><p class=\"soft\">Speeds in km/h, each by one method alone. "
      "The table of vehicles "
      "carries the one that the program stands by.</p><div class=\"scroll\"><table "
      "class=\"cards\"><thead><tr><th>Vehicle</th>";
  for (const Method method : methods)
    html += "<th class=\"number\">" + std::string(words_for(method)) + "</th>";
  html += "</tr></thead><tbody>";
  for (const VehicleResult& vehicle : vehicles) {
    if (vehicle.methods.empty()) continue;
    html += "<tr>" + table_cell("Vehicle", "", track_link(vehicle.track_id));
    for (const Method method : methods)
      html += method_cell(result_of(vehicle, method), words_for(method));
    html += "</tr>";
  }
  return html + "</tbody></table></div>";
}

}  // namespace vildar
