#include "synth/light.h"

#include <array>
#include <cmath>

namespace vildar {
namespace {

constexpr LightColour kHeadlampColour{1.04, 0.90};  // halogen and LED mixed, a little warm
constexpr LightColour kTaillampColour{4.2, 0.2};
constexpr LightColour kStreetLampColour{1.35, 0.35};  // high-pressure sodium

// A film of water on asphalt: mirrors less than a puddle, and its slopes draw the image out.
constexpr double kFilmShare = 0.3;
constexpr double kSlopeSigma_rad = 0.006;
constexpr int kStreakSteps = 9;

void add_mirror_image(const Emitter& lamp, const Eigen::Vector3d& sensor_m,
                      std::vector<Emitter>& emitters) {
  const Eigen::Vector3d image_m(lamp.position_m.x(), lamp.position_m.y(), -lamp.position_m.z());
  const double ground_m = (image_m - sensor_m).head<2>().norm();
  const double grazing_rad = std::atan2(sensor_m.z() - image_m.z(), ground_m);
  double weight_sum = 0.0;
  std::array<double, kStreakSteps> slope_sigmas, weights;
  for (int i = 0; i < kStreakSteps; ++i) {
    const double slope = 4.0 * i / (kStreakSteps - 1) - 2.0;
    slope_sigmas[static_cast<std::size_t>(i)] = slope;
    weights[static_cast<std::size_t>(i)] = std::exp(-0.5 * slope * slope);
    weight_sum += weights[static_cast<std::size_t>(i)];
  }
  for (std::size_t i = 0; i < kStreakSteps; ++i) {
    // A facet tilted by epsilon turns the mirrored ray by twice that.
    const double turned_rad = grazing_rad + 2.0 * kSlopeSigma_rad * slope_sigmas[i];
    if (!(turned_rad > 0.0)) continue;
    Emitter streak = lamp;
    streak.position_m = {image_m.x(), image_m.y(), sensor_m.z() - ground_m * std::tan(turned_rad)};
    streak.intensity_cd *= kFilmShare * water_reflectance(turned_rad) * weights[i] / weight_sum;
    emitters.push_back(streak);
  }
}

}  // namespace

double water_reflectance(double grazing_rad) {
  constexpr double kIndex = 1.33;
  const double cos_in = std::sin(grazing_rad);
  const double sin_out = std::cos(grazing_rad) / kIndex;
  const double cos_out = std::sqrt(1.0 - sin_out * sin_out);
  const double across = (cos_in - kIndex * cos_out) / (cos_in + kIndex * cos_out);
  const double along = (kIndex * cos_in - cos_out) / (kIndex * cos_in + cos_out);
  return 0.5 * (across * across + along * along);
}

bool hidden_by_others(const Scenario& scenario, std::size_t index, const Eigen::Vector3d& point_m,
                      const Eigen::Vector3d& sensor_m, double time_s) {
  for (std::size_t other = 0; other < scenario.vehicles.size(); ++other) {
    if (other == index) continue;
    const VehicleScene& vehicle = scenario.vehicles[other];
    if (body_hides(vehicle, state_at(vehicle, scenario.site.road, time_s), point_m, sensor_m))
      return true;
  }
  return false;
}

std::vector<Emitter> emitters_toward(const Scenario& scenario, const Eigen::Vector3d& sensor_m,
                                     double time_s) {
  std::vector<Emitter> emitters;
  for (const StreetLampScene& lamp : scenario.street_lamps)
    emitters.push_back({{lamp.position_m[0], lamp.position_m[1], lamp.position_m[2]},
                        lamp.radius_m,
                        lamp.intensity_cd,
                        kStreetLampColour,
                        std::nullopt,
                        0});
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    const VehicleScene& vehicle = scenario.vehicles[i];
    const VehicleState state = state_at(vehicle, scenario.site.road, time_s);
    if (!lamps_face(vehicle, state, sensor_m)) continue;
    const bool head = vehicle.lamps == VehicleLamps::head;
    const std::vector<Eigen::Vector3d> lamps_m = lamp_positions_m(vehicle, state);
    for (std::size_t lamp = 0; lamp < lamps_m.size(); ++lamp)
      if (!hidden_by_others(scenario, i, lamps_m[lamp], sensor_m, time_s))
        emitters.push_back({lamps_m[lamp], vehicle.lamp_radius_m, vehicle.intensity_cd,
                            head ? kHeadlampColour : kTaillampColour, i, lamp});
  }
  if (scenario.wet_road) {
    const std::size_t direct = emitters.size();
    for (std::size_t i = 0; i < direct; ++i)
      add_mirror_image(Emitter(emitters[i]), sensor_m, emitters);
  }
  return emitters;
}

}  // namespace vildar
