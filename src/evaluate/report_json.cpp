#include <nlohmann/json.hpp>

#include "core/quantity.h"
#include "evaluate/report.h"

namespace vildar {
namespace {

using Json = nlohmann::ordered_json;

template <class T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json text_or_null(const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); }

Json vehicle_json(const VehicleScore& vehicle) {
  Json json;
  json["vehicle_id"] = text_or_null(vehicle.vehicle_id);
  json["track_id"] = text_or_null(vehicle.track_id);
  json["lane"] = text_or_null(vehicle.lane);
  json["outcome"] = name_of(vehicle.outcome);
  json["withheld"] = text_or_null(vehicle.withheld);
  json["wrong_direction"] = vehicle.wrong_direction;
  json["azimuth_rms_rad"] = or_null(vehicle.azimuth_rms_rad);
  json["range_rms_m"] = or_null(vehicle.range_rms_m);
  if (!vehicle.stated) return json;
  json["t_ref_s"] = vehicle.stated->t_ref_s;
  json["speed_mps"] = vehicle.stated->speed_mps;
  json["speed_std_mps"] = or_null(vehicle.stated->std_mps);
  json["true_speed_mps"] = or_null(vehicle.true_mps);
  if (const auto pair = vehicle.pair()) {
    json["error_kmh"] = kmh_from_mps(pair->error_mps());
    json["error_percent"] = or_null(pair->error_percent());
    json["z"] = or_null(pair->z());
    json["inside_95"] = or_null(pair->inside_95());
    json["within_limits"] = pair->within_limits();
  }
  return json;
}

}  // namespace

std::string json_report(const Evaluation& evaluation,
                        std::span<const RequirementResult> requirements) {
  Json json;
  json["matched_by"] = evaluation.matched_by_image ? "image" : "time";
  json["vehicles"] = Json::array();
  for (const VehicleScore& vehicle : evaluation.vehicles)
    json["vehicles"].push_back(vehicle_json(vehicle));
  json["metrics"] = Json::object();
  for (const NamedMetric& metric : named_metrics(evaluation))
    json["metrics"][metric.name] = or_null(metric.value);
  json["withheld_by_reason"] = evaluation.withheld;
  json["methods"] = Json::object();
  for (const auto& [name, method] : evaluation.methods)
    json["methods"][name]["withheld_by_reason"] = method.withheld;
  json["requirements"] = Json::array();
  for (const RequirementResult& result : requirements)
    json["requirements"].push_back({{"require", result.requirement.text},
                                    {"value", or_null(result.value)},
                                    {"holds", result.holds}});
  json["notes"] = evaluation.notes;
  // Ids and reasons come from files; bytes that are not UTF-8 must not stop the report.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace vildar
