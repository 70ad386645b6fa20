#include "estimate/site_doubts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/text.h"

namespace vildar {
namespace {

constexpr int kFewest = 3;  // vehicles

struct Known {
  const char* name;  // in SpeedBudget::prior_pulls
  const char* larger;
  const char* smaller;
  const char* facts;
};
constexpr std::array<Known, 3> kOfEachVehicle{
    {{"lamp_height", "higher", "lower",
      "lamps.height_m, the camera's height (position_m) and pitch_deg"},
     {"lamp_separation", "wider apart", "closer together",
      "lamps.separation_m, focal_px, the camera's height and pitch_deg"},
     {"lane", "further left", "further right",
      "the lanes' lateral_m, the camera's position_m and yaw_deg"}}};

/// Of vehicles that are pulled alike.
struct Pulls {
  int count = 0;
  double mean = 0.0;
  double mean_acceleration_mps2 = 0.0;

  bool alike(double least_mean, double sigmas) const {
    return count >= kFewest && std::abs(mean) >= least_mean &&
           std::abs(mean) * std::sqrt(count) >= sigmas;
  }
};

template <class Chosen>
Pulls pulls_of(const char* name, std::span<const VehicleResult> vehicles, const Chosen& chosen) {
  Pulls pulls;
  for (const VehicleResult& vehicle : vehicles) {
    if (vehicle.withheld || !vehicle.budget || !vehicle.acceleration_mps2 || !chosen(vehicle))
      continue;
    const auto pull = vehicle.budget->prior_pulls.find(name);
    if (pull == vehicle.budget->prior_pulls.end()) continue;
    ++pulls.count;
    pulls.mean += pull->second;
    pulls.mean_acceleration_mps2 += *vehicle.acceleration_mps2;
  }
  pulls.mean /= std::max(pulls.count, 1);
  pulls.mean_acceleration_mps2 /= std::max(pulls.count, 1);
  return pulls;
}

bool drives(const SpeedEstimate& speed) {
  constexpr double kClear = 3.0;
  return speed.speed_mps > kClear * speed.std_mps;
}

bool is_elsewhere(const VehicleResult& vehicle) {
  return vehicle.withheld == Miss::not_on_road || vehicle.withheld == Miss::bad_fit ||
         vehicle.withheld == Miss::unobservable;
}

bool are_most(const Elsewhere& elsewhere) {
  return elsewhere.count >= kFewest && 2 * elsewhere.count > elsewhere.of;
}

bool goes_along(const VehicleResult& light, const VehicleResult& vehicle) {
  if (vehicle.withheld || !vehicle.used_camera || vehicle.direction != light.direction)
    return false;
  const double together_s =
      std::min(light.t_last_s, vehicle.t_last_s) - std::max(light.t_first_s, vehicle.t_first_s);
  return 2.0 * together_s > light.t_last_s - light.t_first_s;
}

// Most of those that the camera followed do not move as the site file asks for.
void doubt_the_view(std::span<const VehicleResult> vehicles, std::vector<std::string>& doubts) {
  Elsewhere elsewhere;
  for (const VehicleResult& vehicle : vehicles) {
    if (vehicle.n_frames == 0) continue;
    ++elsewhere.of;
    elsewhere.count += is_elsewhere(vehicle);
  }
  if (!are_most(elsewhere)) return;
  doubts.push_back(
      std::to_string(elsewhere.count) + " of " + std::to_string(elsewhere.of) +
      " vehicles do not move as on the road stated, seen from the camera stated: check "
      "the camera's position_m, yaw_deg, pitch_deg and focal_px, the lanes, and "
      "road.kind, turn, straight_m and radius_m; a stand that sways does the same: stay it, "
      "or keep lights that stand in its view for the whole clip, above the road best");
}

void doubt_the_lanes(std::span<const VehicleResult> vehicles, const RoadSite& road,
                     std::vector<std::string>& doubts) {
  constexpr double kLikely = 0.7;
  const auto has_lanes = [&](Direction direction) {
    return std::ranges::find(road.lanes, direction, &LaneSite::direction) != road.lanes.end();
  };
  int drive = 0, in_none = 0;
  for (const VehicleResult& vehicle : vehicles) {
    if (vehicle.withheld || !vehicle.used_camera || !drives(vehicle.speed)) continue;
    if (!has_lanes(vehicle.direction)) continue;
    ++drive;
    in_none += vehicle.no_lane_probability > kLikely;
  }
  if (in_none < 2 || 2 * in_none <= drive) return;
  doubts.push_back(std::to_string(in_none) + " of " + std::to_string(drive) +
                   " vehicles drive in none of the lanes told for their direction: add their lanes "
                   "where they are left out; else check the lanes' lateral_m and direction and the "
                   "camera's position_m, yaw_deg and pitch_deg, with which their speeds are off");
}

// On a bend told the other way, but also before a stop line.
void doubt_the_bend(std::span<const VehicleResult> vehicles, std::vector<std::string>& doubts) {
  for (const auto& [direction, name] :
       {std::pair(Direction::oncoming, "oncoming"), std::pair(Direction::receding, "receding")}) {
    const Pulls pulls = pulls_of(
        "acceleration", vehicles,
        [side = direction](const VehicleResult& vehicle) { return vehicle.direction == side; });
    if (!pulls.alike(0.9, 3.0)) continue;
    const double mean_mps2 = pulls.mean_acceleration_mps2;
    doubts.push_back(std::to_string(pulls.count) + " " + name + " vehicles seem to " +
                     (pulls.mean > 0.0 ? "speed up" : "brake") + " by " +
                     fixed_text(std::abs(mean_mps2), 1) +
                     " m/s2 on average; where they do not, their speeds are off: check whether the "
                     "road bends as the site file says, and the camera's yaw_deg");
  }
}

}  // namespace

std::vector<std::string> site_doubts(std::span<const VehicleResult> vehicles,
                                     const RoadSite& road) {
  std::vector<std::string> doubts;
  doubt_the_view(vehicles, doubts);
  doubt_the_lanes(vehicles, road, doubts);
  for (const Known& known : kOfEachVehicle) {
    const Pulls pulls = pulls_of(known.name, vehicles, [](const VehicleResult&) { return true; });
    if (!pulls.alike(2.0, 4.5)) continue;
    doubts.push_back("the lamps of " + std::to_string(pulls.count) + " vehicles come out " +
                     (pulls.mean > 0.0 ? known.larger : known.smaller) +
                     " than the site file says, by " + fixed_text(std::abs(pulls.mean), 1) +
                     " sigmas of that difference on average, and their speeds are off with them: "
                     "check " +
                     known.facts);
  }
  doubt_the_bend(vehicles, doubts);
  return doubts;
}

std::optional<Elsewhere> most_elsewhere(std::span<const VehicleResult> vehicles) {
  Elsewhere elsewhere;
  for (const VehicleResult& vehicle : vehicles) {
    if (vehicle.n_frames == 0) continue;
    const auto along = [&](const VehicleResult& other) { return goes_along(vehicle, other); };
    if (vehicle.withheld == Miss::not_on_road && std::ranges::any_of(vehicles, along)) continue;
    ++elsewhere.of;
    elsewhere.count += is_elsewhere(vehicle);
  }
  if (!are_most(elsewhere)) return std::nullopt;
  return elsewhere;
}

}  // namespace vildar
