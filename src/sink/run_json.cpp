#include <cmath>
#include <variant>

#include <nlohmann/json.hpp>

#include "core/quantity.h"
#include "sink/run_summary.h"

namespace vildar {
namespace {

using Json = nlohmann::ordered_json;

void put(Json& object, const char* key, std::optional<double> value) {
  if (value && std::isfinite(*value)) object[key] = *value;
}

void put_estimate(Json& object, const SpeedEstimate& speed) {
  put(object, "t_ref_s", speed.time_s);
  put(object, "speed_mps", speed.speed_mps);
  put(object, "speed_std_mps", speed.std_mps);
  put(object, "speed_lo95_mps", speed.lo95_mps);
  put(object, "speed_hi95_mps", speed.hi95_mps);
}

std::string status_of(std::optional<Miss> withheld) {
  return withheld ? "withheld:" + std::string(name_of(*withheld)) : "measured";
}

Json json_of(const MethodResult& result) {
  const auto* speed = std::get_if<SpeedEstimate>(&result.speed);
  Json json{
      {"method", name_of(result.method)},
      {"status", status_of(speed ? std::nullopt : std::optional(std::get<Miss>(result.speed)))}};
  if (speed) put_estimate(json, *speed);
  json["n_samples"] = result.samples;
  if (!result.k_source.empty()) json["k_source"] = result.k_source;
  return json;
}

Json json_of(const VehicleResult& vehicle) {
  Json json{{"track_id", vehicle.track_id}, {"direction", name_of(vehicle.direction)}};
  if (!vehicle.lane.empty()) json["lane"] = vehicle.lane;
  json["status"] = status_of(vehicle.withheld);
  put(json, "t_first_s", vehicle.t_first_s);
  put(json, "t_last_s", vehicle.t_last_s);
  put(json, "lateral_m", vehicle.lateral_m);
  if (!vehicle.withheld) {
    put_estimate(json, vehicle.speed);
    put(json, "speed_kmh", kmh_from_mps(vehicle.speed.speed_mps));
    put(json, "range_ref_m", vehicle.range_ref_m);
    put(json, "acceleration_mps2", vehicle.acceleration_mps2);
    put(json, "closing_speed_mps", vehicle.closing_speed_mps);
    json["method"] = name_of(vehicle.method);
    if (vehicle.budget)
      json["budget"] = {{"shape", vehicle.budget->shape},
                        {"scale", vehicle.budget->scale},
                        {"scale_shares", vehicle.budget->scale_shares},
                        {"prior_pulls", vehicle.budget->prior_pulls}};
    if (!vehicle.chi2_per_dof.empty()) json["chi2_per_dof"] = vehicle.chi2_per_dof;
  }
  json["sensors"] = Json::array();
  if (vehicle.used_camera) json["sensors"].push_back("camera");
  if (vehicle.used_photodiode) json["sensors"].push_back("photodiode");
  json["n_frames"] = vehicle.n_frames;
  json["n_pd_samples"] = vehicle.n_pd_samples;
  json["methods"] = Json::array();
  for (const MethodResult& result : vehicle.methods) json["methods"].push_back(json_of(result));
  json["warnings"] = vehicle.warnings;
  return json;
}

Json json_of(const ClipSummary& clip) {
  Json json{{"container", clip.container},       {"codec", clip.codec},
            {"pixel_format", clip.pixel_format}, {"width_px", clip.width_px},
            {"height_px", clip.height_px},       {"rotation_deg", clip.rotation_deg}};
  put(json, "nominal_frame_rate_hz", clip.nominal_frame_rate_hz);
  put(json, "duration_s", clip.duration_s);
  return json;
}

Json json_of(const TraceSummary& trace) {
  Json json{{"id", trace.photodiode}};
  put(json, "sample_rate_hz", trace.sample_rate_hz);
  put(json, "noise_w", trace.noise_w);
  put(json, "ambient_w", trace.ambient_w);
  put(json, "ambient_std_w", trace.ambient_std_w);
  put(json, "drift_w", trace.drift_w);
  put(json, "flicker_w", trace.flicker_w);
  if (trace.switched_w > 0.0) put(json, "switched_w", trace.switched_w);
  if (trace.mains_hz > 0.0) put(json, "mains_hz", trace.mains_hz);
  for (const PulsingLight& light : trace.pulsing) {
    Json one;
    put(one, "from_s", light.from_s);
    put(one, "to_s", light.to_s);
    put(one, "frequency_hz", light.frequency_hz);
    put(one, "duty", light.duty);
    put(one, "duty_std", light.duty_std);
    json["pulsing_lamps"].push_back(std::move(one));
  }
  return json;
}

}  // namespace

std::string run_json_text(const RunSummary& summary, std::span<const VehicleResult> vehicles) {
  Json json{{"format", 1}, {"program", "vildar"}, {"version", summary.version}};
  if (!summary.started.empty()) json["started"] = summary.started;
  json["damaged"] = summary.damaged;
  json["warnings"] = summary.warnings;
  json["inputs"] = Json::array();
  for (const InputFile& input : summary.inputs)
    json["inputs"].push_back({{"role", input.role},
                              {"path", input.path.string()},
                              {"size_bytes", input.size_bytes},
                              {"sha256", input.sha256}});
  if (summary.clip) json["clip"] = json_of(*summary.clip);
  for (const TraceSummary& trace : summary.traces) json["photodiodes"].push_back(json_of(trace));
  json["counts"] = summary.counts;
  json["rejected_samples"] = summary.rejected_samples;
  json["timings_s"] = summary.timings_s;
  json["settings"] = {{"options", summary.options}, {"site_yaml", summary.settings_yaml}};
  json["vehicles"] = Json::array();
  for (const VehicleResult& vehicle : vehicles) json["vehicles"].push_back(json_of(vehicle));
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

AtomicFile write_run_json(const std::filesystem::path& path, const RunSummary& summary,
                          std::span<const VehicleResult> vehicles) {
  return finished_file(path, run_json_text(summary, vehicles));
}

}  // namespace vildar
