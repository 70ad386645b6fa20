#include "synth/truth.h"

#include <algorithm>
#include <cmath>

#include "core/text.h"
#include "synth/ego.h"
#include "synth/frame_times.h"
#include "synth/light.h"
#include "synth/photodiode_trace.h"
#include "synth/row_time.h"
#include "types/result.h"

namespace vildar {
namespace {

constexpr double kRateWithoutCamera_hz = 100.0;

void see_with_camera(const Scenario& scenario, const Camera& camera, const CameraShake& shake,
                     const std::vector<VehicleState>& states, TruthTrackRow& row) {
  const CameraSite& site = *scenario.site.camera;
  const VehicleScene& vehicle = scenario.vehicles[row.vehicle];
  if (!lamps_face(vehicle, states[row.vehicle], camera.position_m())) return;
  const std::vector<Eigen::Vector3d> lamps_m = lamp_positions_m(vehicle, states[row.vehicle]);
  std::vector<Eigen::Vector2d> pixels;
  int hidden = 0;
  const std::size_t lamps = vehicle.lamp_separation_m == 0.0 ? 1 : 2;
  bool first_is_left = true;
  std::vector<std::optional<Eigen::Vector2d>> found(lamps);
  double order[2] = {0.0, 0.0};
  for (std::size_t lamp = 0; lamp < lamps; ++lamp) {
    const auto position_m = [&](double at_s) {
      return shake.steady_m(
          lamp_positions_m(vehicle, seen_state_at(scenario, row.vehicle, at_s))[lamp], at_s);
    };
    const auto sighting = sighting_at_row_time(camera, site, row.time_s, position_m);
    if (!sighting) continue;
    order[lamp] = sighting->pixel_px.x();
    if (!inside_image(site, sighting->pixel_px)) continue;
    found[lamp] = sighting->pixel_px;
    hidden += hidden_by_others(scenario, states, row.vehicle, lamps_m[lamp], camera.position_m());
  }
  if (lamps == 2) first_is_left = order[0] <= order[1];
  row.left_px = found[first_is_left ? 0 : 1];
  if (lamps == 2) row.right_px = found[first_is_left ? 1 : 0];
  const int shown = row.left_px.has_value() + row.right_px.has_value();
  row.occluded = shown > 0 && hidden == shown;
  row.seen = shown > 0 && !row.occluded;
}

std::string pixel_cells(const std::optional<Eigen::Vector2d>& pixel_px) {
  if (!pixel_px) return ",";
  return fixed_text(pixel_px->x(), 4) + "," + fixed_text(pixel_px->y(), 4);
}

}  // namespace

std::vector<TruthTrackRow> truth_tracks(const Scenario& scenario) {
  std::optional<Camera> camera;
  if (scenario.site.camera) camera.emplace(*scenario.site.camera);
  const CameraShake shake(scenario);
  std::vector<double> times_s;
  if (camera)
    times_s = frame_times_s(scenario);
  else
    for (int i = 0; i / kRateWithoutCamera_hz < scenario.duration_s - 1e-9; ++i)
      times_s.push_back(i / kRateWithoutCamera_hz);
  std::vector<TruthTrackRow> rows;
  std::vector<bool> ever_seen(scenario.vehicles.size(), false);
  for (std::size_t frame = 0; frame < times_s.size(); ++frame) {
    const std::vector<VehicleState> states = states_at(scenario, times_s[frame]);
    for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
      TruthTrackRow row;
      row.frame = static_cast<std::int64_t>(frame);
      row.time_s = times_s[frame];
      row.vehicle = i;
      row.place_m = states[i].place_m;
      row.speed_mps = states[i].speed_mps;
      row.acceleration_mps2 = states[i].acceleration_mps2;
      if (camera)
        see_with_camera(scenario, *camera, shake, states, row);
      else
        for (const PhotodiodeSite& photodiode : scenario.site.photodiodes)
          row.seen = row.seen || vehicle_power_w(scenario, states, i, photodiode, row.time_s) > 0.0;
      ever_seen[i] = ever_seen[i] || row.seen;
      rows.push_back(row);
    }
  }
  std::erase_if(rows, [&](const TruthTrackRow& row) { return !ever_seen[row.vehicle]; });
  return rows;
}

std::string truth_tracks_csv(const Scenario& scenario, const std::vector<TruthTrackRow>& rows) {
  std::string text =
      "frame,t_s,vehicle_id,u_left_px,v_left_px,u_right_px,v_right_px,x_m,y_m,range_m,speed_mps,"
      "occluded\n";
  for (const TruthTrackRow& row : rows) {
    const std::string x_text = fixed_text(row.place_m.x(), 4);
    text += std::to_string(row.frame) + "," + fixed_text(row.time_s, 6) + "," +
            scenario.vehicles[row.vehicle].id + "," + pixel_cells(row.left_px) + "," +
            pixel_cells(row.right_px) + "," + x_text + "," + fixed_text(row.place_m.y(), 4) + "," +
            x_text + "," + fixed_text(row.speed_mps, 4) + (row.occluded ? ",1\n" : ",0\n");
  }
  return text;
}

std::string truth_vehicles_csv(const Scenario& scenario, const std::vector<TruthTrackRow>& rows) {
  std::string text =
      "vehicle_id,direction,lane,t_ref_s,speed_mps,range_ref_m,lateral_m,acceleration_mps2\n";
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    std::optional<double> first_s, last_s;
    for (const TruthTrackRow& row : rows)
      if (row.vehicle == i && row.seen) {
        if (!first_s) first_s = row.time_s;
        last_s = row.time_s;
      }
    if (!first_s) continue;
    const double ref_s = 0.5 * (*first_s + *last_s);
    const VehicleScene& vehicle = scenario.vehicles[i];
    const VehicleState state = seen_state_at(scenario, i, ref_s);
    const std::vector<LaneSite>& lanes = scenario.site.road.lanes;
    const Direction direction = lanes[static_cast<std::size_t>(vehicle.lane)].direction;
    const std::string& lane = lanes[static_cast<std::size_t>(lane_at(vehicle, ref_s))].id;
    text += vehicle.id + "," + std::string(name_of(direction)) + "," + lane + "," +
            fixed_text(ref_s, 6) + "," + fixed_text(state.speed_mps, 6) + "," +
            fixed_text(state.place_m.x(), 4) + "," + fixed_text(state.place_m.y(), 4) + "," +
            fixed_text(state.acceleration_mps2, 4) + "\n";
  }
  return text;
}

}  // namespace vildar
