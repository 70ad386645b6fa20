#include "estimate/lamp_size.h"

#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/clock.h"

namespace vildar {
namespace {

constexpr std::size_t kFewestPictures = 3;
/// By which coding shifts the radius in all pictures of a lamp alike, near and far, px.
constexpr double kShift_px = 0.05;

double distance_at(const Trajectory& trajectory, double time_s, double side) {
  const GeometryProblem& problem = trajectory.problem;
  return lamp_from_camera_m(trajectory.fit.parameters.data(), problem.setting,
                            time_s - problem.reference_s, problem.pairs ? side : 0.0,
                            trajectory.ego.deviation(problem.reference_s, time_s))
      .norm();
}

bool tells_size(const LampSighting& lamp) {
  return lamp.lamp && lamp.lamp->coded && lamp.lamp->radius_sigma_px > 0.0 &&
         !has(lamp.defects, Defect::merged) && !has(lamp.defects, Defect::cut_by_edge);
}

}  // namespace

void hold_size(std::span<const double> distance_m, std::span<LampLight> lights) {
  if (distance_m.size() != lights.size() || lights.empty())
    throw std::invalid_argument("hold_size: as many distances as lights are needed, at least one");
  // The size in px m, that is times the focal length: weighed means of radius times distance, and
  // what a shift of every radius does to it.
  double weight = 0.0, size_px_m = 0.0, shift_m = 0.0;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    if (!(lights[i].radius_px > 0.0 && lights[i].radius_sigma_px > 0.0))
      throw std::invalid_argument("hold_size: every light needs a radius and its sigma");
    const double here = 1.0 / std::pow(distance_m[i] * lights[i].radius_sigma_px, 2);
    weight += here;
    size_px_m += here * distance_m[i] * lights[i].radius_px;
    shift_m += here * distance_m[i];
  }
  size_px_m /= weight;
  const double sigma_px_m = std::hypot(1.0 / std::sqrt(weight), kShift_px * shift_m / weight);
  for (std::size_t i = 0; i < lights.size(); ++i) {
    LampLight& light = lights[i];
    const double radius_px = size_px_m / distance_m[i];
    const double further_px = radius_px - light.radius_px;
    const double change = light.log_flux_per_radius * further_px;
    // The light goes with the radius where that is large, with its square where it is small.
    const double bend = change * further_px / (2.0 * light.radius_px);
    light.radius_px = radius_px;
    light.radius_sigma_px = sigma_px_m / distance_m[i];
    light.flux *= std::exp(change);
    light.flux_sigma =
        light.flux * std::hypot(light.log_flux_sigma_at_radius,
                                light.log_flux_per_radius * light.radius_sigma_px, bend);
  }
}

VehicleTrack with_held_sizes(VehicleTrack track, const Trajectory& trajectory,
                             const CameraSite& camera) {
  for (const auto& [lamp_of, side] :
       {std::pair{&VehicleSighting::left, 0.5}, std::pair{&VehicleSighting::right, -0.5}}) {
    std::vector<double> distance_m;
    std::vector<LampLight> lights;
    std::vector<LampLight*> places;
    for (VehicleSighting& sighting : track.sightings) {
      std::optional<LampSighting>& lamp = sighting.*lamp_of;
      if (!lamp || !tells_size(*lamp)) continue;
      const double time_s =
          seconds_of(row_time(sighting.time, camera.rolling_shutter_s, lamp->row_fraction));
      if (time_s < trajectory.from_s || time_s > trajectory.to_s) continue;
      distance_m.push_back(distance_at(trajectory, time_s, side));
      lights.push_back(*lamp->lamp);
      places.push_back(&*lamp->lamp);
    }
    if (lights.size() < kFewestPictures) continue;
    hold_size(distance_m, lights);
    for (std::size_t i = 0; i < lights.size(); ++i) *places[i] = lights[i];
  }
  return track;
}

}  // namespace vildar
