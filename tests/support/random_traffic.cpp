#include "support/random_traffic.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/random.h"
#include "synth/random_site.h"

namespace vildar {
namespace {

constexpr double kDuration_s = 4.0;
constexpr double kNearest_m = 12.0, kFarthest_m = 110.0;  // at half time
constexpr double kShortestGap_m = 9.0, kLorry_m = 10.0;   // from lamps to lamps; more past a lorry

Site told(Random& random) {
  Site site = told_site(ScenePreset::three_lanes, random);
  site.photodiodes.clear();
  site.road.lanes.push_back({"back_near", {3.0, 0.0}, 3.5, Direction::receding});
  site.road.lanes.push_back({"back_far", {6.5, 0.0}, 3.5, Direction::receding});
  return site;
}

double sign_of(Direction direction) { return direction == Direction::oncoming ? -1.0 : 1.0; }

double place_m(const VehicleScene& vehicle, const Site& site, double t_s) {
  const auto& lane = site.road.lanes[static_cast<std::size_t>(vehicle.lane)];
  return vehicle.along_at_zero_m + sign_of(lane.direction) * vehicle.speed_mps * t_s;
}

bool collide(const VehicleScene& a, const VehicleScene& b, const Site& site) {
  if (a.lane != b.lane) return false;
  const bool lorry = a.kind == VehicleKind::lorry || b.kind == VehicleKind::lorry;
  const double least_m = kShortestGap_m + (lorry ? kLorry_m : 0.0);
  const double before_m = place_m(a, site, 0.0) - place_m(b, site, 0.0);
  const double after_m = place_m(a, site, kDuration_s) - place_m(b, site, kDuration_s);
  return std::min(std::abs(before_m), std::abs(after_m)) < least_m || before_m * after_m < 0.0;
}

VehicleScene drawn_vehicle(const Site& site, const Site& told, const std::vector<double>& pace_mps,
                           Random& random) {
  constexpr double kMotorcycles = 0.12, kLorries = 0.1;
  VehicleScene vehicle;
  const auto lanes = static_cast<double>(site.road.lanes.size());
  vehicle.lane = std::min(static_cast<int>(random.uniform() * lanes), static_cast<int>(lanes) - 1);
  const auto lane = static_cast<std::size_t>(vehicle.lane);
  const Direction direction = site.road.lanes[lane].direction;
  vehicle.speed_mps = pace_mps[lane] * std::exp(random.normal(0.0, 0.08));
  vehicle.along_at_zero_m = random.uniform(kNearest_m, kFarthest_m) -
                            sign_of(direction) * vehicle.speed_mps * 0.5 * kDuration_s;
  vehicle.lateral_offset_m = random.normal(0.0, site.road.lanes[lane].width_m / 12.0);
  vehicle.lamp_height_m =
      std::max(0.4, random.normal(told.lamps.height_m->mean, told.lamps.height_m->std));
  vehicle.lamp_separation_m =
      std::max(0.8, random.normal(told.lamps.separation_m->mean, told.lamps.separation_m->std));
  const double kind = random.uniform();
  if (kind < kMotorcycles) {
    vehicle.kind = VehicleKind::motorcycle;
    vehicle.lamp_height_m = 0.85;
    vehicle.lamp_separation_m = 0.0;
  } else if (kind < kMotorcycles + kLorries) {
    vehicle.kind = VehicleKind::lorry;
    vehicle.lamp_height_m = 0.9;
    vehicle.lamp_separation_m = 1.9;
  }
  const bool tail = direction == Direction::receding;
  vehicle.lamps = tail ? VehicleLamps::tail : VehicleLamps::head;
  vehicle.intensity_cd = (tail ? 8.0 : 600.0) * std::exp(random.normal(0.0, 0.4));
  return vehicle;
}

}  // namespace

Scenario random_traffic(std::uint64_t seed, int vehicles, bool wet) {
  Random random(seed);
  Scenario scene;
  scene.duration_s = kDuration_s;
  scene.seed = seed;
  scene.told_site = told(random);
  scene.site = drawn_site(*scene.told_site, random);
  scene.wet_road = wet;
  scene.image.road_cd_per_m2 = 0.3;
  scene.encoder.crf = 23;
  std::vector<double> pace_mps;
  for (std::size_t lane = 0; lane < scene.site.road.lanes.size(); ++lane)
    pace_mps.push_back(random.uniform(5.0, 30.0));
  constexpr int kMostTries = 400;
  for (int tries = 0; std::ssize(scene.vehicles) < vehicles && tries < kMostTries; ++tries) {
    VehicleScene vehicle = drawn_vehicle(scene.site, *scene.told_site, pace_mps, random);
    vehicle.id = "v" + std::to_string(scene.vehicles.size() + 1);
    if (std::none_of(scene.vehicles.begin(), scene.vehicles.end(), [&](const VehicleScene& other) {
          return collide(vehicle, other, scene.site);
        }))
      scene.vehicles.push_back(vehicle);
  }
  return scene;
}

}  // namespace vildar
