#include "synth/light.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "optics/atmosphere.h"
#include "optics/fresnel.h"
#include "synth/ego.h"

namespace vildar {
namespace {

constexpr LightColour kHeadlampColour{1.04, 0.90};  // halogen and LED mixed, a little warm
constexpr LightColour kTaillampColour{4.2, 0.2};
constexpr LightColour kStreetLampColour{1.35, 0.35};  // high-pressure sodium

// A film of water on asphalt: mirrors less than a puddle, and its slopes draw the image out.
constexpr double kFilmShare = 0.3;
constexpr double kSlopeSigma_rad = 0.006;
constexpr int kStreakSteps = 9;

struct Streak {
  double share = 0.0;     ///< of the lamp's light that the water sends on
  double mean_rad = 0.0;  ///< below the horizontal
  double std_rad = 0.0;
};

// Facets of the film tilt by a normal law; each mirrors by Fresnel, the flat ones less so.
Streak streak_at(double grazing_rad) {
  Streak streak;
  double weights = 0.0, square = 0.0;
  for (int i = 0; i < kStreakSteps; ++i) {
    const double slope = 4.0 * i / (kStreakSteps - 1) - 2.0;
    const double weight = std::exp(-0.5 * slope * slope);
    weights += weight;
    // A facet tilted by epsilon turns the mirrored ray by twice that.
    const double turned_rad = grazing_rad + 2.0 * kSlopeSigma_rad * slope;
    if (!(turned_rad > 0.0)) continue;
    const double light = weight * wet_mirror_share(Radians(turned_rad), kFilmShare);
    streak.share += light;
    streak.mean_rad += light * turned_rad;
    square += light * turned_rad * turned_rad;
  }
  if (!(streak.share > 0.0)) return streak;
  streak.mean_rad /= streak.share;
  streak.std_rad =
      std::sqrt(std::max(0.0, square / streak.share - streak.mean_rad * streak.mean_rad));
  streak.share /= weights;
  return streak;
}

std::optional<Emitter> mirror_image(const Scenario& scenario,
                                    const std::vector<VehicleState>& states, const Emitter& lamp,
                                    const Eigen::Vector3d& sensor_m, double time_s) {
  const Eigen::Vector3d image_m(lamp.position_m.x(), lamp.position_m.y(), -lamp.position_m.z());
  const double ground_m = (image_m - sensor_m).head<2>().norm();
  const Streak streak = streak_at(std::atan2(sensor_m.z() - image_m.z(), ground_m));
  if (!(streak.share > 0.0)) return std::nullopt;
  Emitter mirror = lamp;
  mirror.position_m.z() = sensor_m.z() - ground_m * std::tan(streak.mean_rad);
  mirror.offset_m = mirror.position_m - lamp.position_m;
  mirror.streak_rad = streak.std_rad;
  if (lamp.vehicle) {
    // The light that meets the road leaves the lamp toward the sensor's own mirror image.
    const Eigen::Vector3d below_m(sensor_m.x(), sensor_m.y(), -sensor_m.z());
    mirror.intensity_cd = lamp_intensity_cd(scenario.vehicles[*lamp.vehicle], states[*lamp.vehicle],
                                            lamp.position_m, below_m, time_s);
    mirror.intensity_cd *=
        transmittance(scenario.extinction_per_m, Metres((image_m - sensor_m).norm()));
  }
  mirror.intensity_cd *= streak.share;
  return mirror;
}

LightColour colour_of(const VehicleScene& vehicle) {
  return vehicle.lamps == VehicleLamps::head ? kHeadlampColour : kTaillampColour;
}

}  // namespace

bool hidden_by_others(const Scenario& scenario, const std::vector<VehicleState>& states,
                      std::size_t index, const Eigen::Vector3d& point_m,
                      const Eigen::Vector3d& sensor_m) {
  for (std::size_t other = 0; other < states.size(); ++other)
    if (other != index && body_hides(scenario.vehicles[other], states[other], point_m, sensor_m))
      return true;
  return false;
}

double lamp_intensity_cd(const VehicleScene& vehicle, const VehicleState& state,
                         const Eigen::Vector3d& lamp_m, const Eigen::Vector3d& toward_m,
                         double time_s) {
  if (!vehicle.beam) return vehicle.intensity_cd;
  const bool head = vehicle.lamps == VehicleLamps::head;
  const Eigen::Vector2d ahead = head ? state.forward : Eigen::Vector2d(-state.forward);
  const double nose_rad = pitch_rad_at(vehicle, time_s);
  return vehicle.beam->intensity_cd(vehicle_from_road(
      toward_m - lamp_m, std::atan2(ahead.y(), ahead.x()), head ? nose_rad : -nose_rad));
}

Eigen::Vector3d emitter_position_m(const Scenario& scenario, const Emitter& emitter,
                                   double time_s) {
  if (emitter.vehicle)
    return lamp_positions_m(scenario.vehicles[*emitter.vehicle],
                            seen_state_at(scenario, *emitter.vehicle, time_s))[emitter.lamp] +
           emitter.offset_m;
  const std::array<double, 3>& still_m = scenario.street_lamps[emitter.lamp].position_m;
  const Eigen::Vector2d seen_m =
      ego_pose(scenario.site, time_s).seen_m({still_m[0], still_m[1]});
  return Eigen::Vector3d(seen_m.x(), seen_m.y(), still_m[2]) + emitter.offset_m;
}

std::vector<Emitter> emitters_toward(const Scenario& scenario, const Eigen::Vector3d& sensor_m,
                                     double time_s) {
  std::vector<Emitter> emitters;
  const auto add = [&](Emitter emitter) {
    emitter.intensity_cd *=
        transmittance(scenario.extinction_per_m, Metres((emitter.position_m - sensor_m).norm()));
    emitters.push_back(emitter);
  };
  for (std::size_t i = 0; i < scenario.street_lamps.size(); ++i) {
    const StreetLampScene& lamp = scenario.street_lamps[i];
    Emitter emitter;
    emitter.lamp = i;
    emitter.position_m = emitter_position_m(scenario, emitter, time_s);
    emitter.radius_m = lamp.radius_m;
    emitter.intensity_cd = lamp.intensity_cd;
    emitter.colour = kStreetLampColour;
    emitter.waveform = lamp.waveform;
    add(emitter);
  }
  const std::vector<VehicleState> states = states_at(scenario, time_s);
  for (std::size_t i = 0; i < scenario.vehicles.size(); ++i) {
    const VehicleScene& vehicle = scenario.vehicles[i];
    if (!lamps_face(vehicle, states[i], sensor_m)) continue;
    const std::vector<Eigen::Vector3d> lamps_m = lamp_positions_m(vehicle, states[i]);
    for (std::size_t lamp = 0; lamp < lamps_m.size(); ++lamp) {
      if (hidden_by_others(scenario, states, i, lamps_m[lamp], sensor_m)) continue;
      Emitter emitter;
      emitter.position_m = lamps_m[lamp];
      emitter.radius_m = vehicle.lamp_radius_m;
      emitter.intensity_cd = lamp_intensity_cd(vehicle, states[i], lamps_m[lamp], sensor_m, time_s);
      emitter.colour = colour_of(vehicle);
      emitter.waveform = vehicle.waveform;
      emitter.vehicle = i;
      emitter.lamp = lamp;
      add(emitter);
    }
  }
  if (scenario.wet_road) {
    const std::size_t direct = emitters.size();
    for (std::size_t i = 0; i < direct; ++i)
      if (const auto mirror = mirror_image(scenario, states, emitters[i], sensor_m, time_s))
        emitters.push_back(*mirror);
  }
  return emitters;
}

}  // namespace vildar
