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
constexpr double kSlopeSigma_rad = 0.015;
constexpr double kSteepestSlope = 3.0;  // sigmas
constexpr int kStreakSteps = 13;

// Where facets of the film that are tilted toward the sensor by `tilt_rad` send it the light of a
// lamp `away_m` off, as a distance on the ground from the sensor: there the ray goes up to the
// sensor by twice the tilt more steeply than it comes down from the lamp. Small angles.
double mirroring_place_m(double sensor_height_m, double lamp_height_m, double away_m,
                         double tilt_rad) {
  // 2 tilt x^2 - (H + h + 2 tilt R) x + H R = 0, the root between 0 and R.
  const double linear = sensor_height_m + lamp_height_m + 2.0 * tilt_rad * away_m;
  const double root = std::sqrt(linear * linear - 8.0 * tilt_rad * sensor_height_m * away_m);
  return 2.0 * sensor_height_m * away_m / (linear + root);
}

// The image of a lamp in the film, in pieces from far to near. Slopes upright to the line of sight
// follow a normal law; those across it move the light by a fraction of its lamp's width. Light
// leaves the water between lamp and sensor alone, so nothing shines above the ground under a lamp.
void add_mirror_images(const Scenario& scenario, const std::vector<VehicleState>& states,
                       const Emitter& lamp, const Eigen::Vector3d& sensor_m, double time_s,
                       std::vector<Emitter>& images) {
  const double sensor_height_m = sensor_m.z(), lamp_height_m = lamp.position_m.z();
  const Eigen::Vector2d line_m = (lamp.position_m - sensor_m).head<2>();
  const double away_m = line_m.norm();
  if (!(sensor_height_m > 0.0 && lamp_height_m > 0.0 && away_m > 0.0)) return;
  std::array<double, kStreakSteps> places_m{}, slopes{};
  double slope_weights = 0.0;
  for (std::size_t i = 0; i < kStreakSteps; ++i) {
    slopes[i] = kSteepestSlope * (2.0 * static_cast<double>(i) / (kStreakSteps - 1) - 1.0);
    places_m[i] =
        mirroring_place_m(sensor_height_m, lamp_height_m, away_m, kSlopeSigma_rad * slopes[i]);
    slope_weights += std::exp(-0.5 * slopes[i] * slopes[i]);
  }
  const auto down_rad = [&](std::size_t i) { return std::atan2(sensor_height_m, places_m[i]); };
  for (std::size_t i = 0; i < kStreakSteps; ++i) {
    const double near_m = places_m[i], far_m = away_m - near_m;
    const double up_rad = down_rad(i), in_rad = std::atan2(lamp_height_m, far_m);
    // Of an image in still water: less of the light from a lamp falls on as much of the road where
    // that is farther from it, and spreads over more on the way on.
    const double of_still = away_m * lamp_height_m * near_m /
                            (sensor_height_m * far_m * far_m + lamp_height_m * near_m * near_m);
    const double share = std::exp(-0.5 * slopes[i] * slopes[i]) / slope_weights * of_still *
                         wet_mirror_share(Radians(0.5 * (up_rad + in_rad)), kFilmShare);
    Emitter image = lamp;
    image.position_m.z() = sensor_height_m - away_m * std::tan(up_rad);
    image.offset_m = image.position_m - lamp.position_m;
    const std::size_t before = i > 0 ? i - 1 : i, after = i + 1 < kStreakSteps ? i + 1 : i;
    image.streak_rad =
        0.6 * std::abs(down_rad(after) - down_rad(before)) / static_cast<double>(after - before);
    if (lamp.vehicle) {
      const Eigen::Vector2d ground_m = sensor_m.head<2>() + line_m * (near_m / away_m);
      image.intensity_cd =
          lamp_intensity_cd(scenario.vehicles[*lamp.vehicle], states[*lamp.vehicle],
                            lamp.position_m, {ground_m.x(), ground_m.y(), 0.0}, time_s);
      image.intensity_cd *=
          transmittance(scenario.extinction_per_m, Metres((image.position_m - sensor_m).norm()));
    }
    image.intensity_cd *= share;
    if (image.intensity_cd > 0.0) images.push_back(image);
  }
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
  const Eigen::Vector2d seen_m = ego_pose(scenario.site, time_s).seen_m({still_m[0], still_m[1]});
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
      add_mirror_images(scenario, states, Emitter(emitters[i]), sensor_m, time_s, emitters);
  }
  return emitters;
}

}  // namespace vildar
