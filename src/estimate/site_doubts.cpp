#include "estimate/site_doubts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/text.h"

namespace vildar {
namespace {

struct Known {
  const char* name;  // in SpeedBudget::prior_pulls
  const char* larger;
  const char* smaller;
  const char* facts;
};
constexpr std::array<Known, 3> kOfEachVehicle{
    {{"lamp_height", "lower", "higher",
      "lamps.height_m, the camera's height (position_m) and pitch_deg"},
     {"lamp_separation", "wider apart", "closer together",
      "lamps.separation_m, focal_px, the camera's height and pitch_deg"},
     {"lane", "further left", "further right",
      "the lanes' lateral_m, the camera's position_m and yaw_deg"}}};

struct Pulls {
  int count = 0;
  double mean = 0.0;

  bool alike(double least_mean, double sigmas) const {
    constexpr int kFewest = 3;
    return count >= kFewest && std::abs(mean) >= least_mean &&
           std::abs(mean) * std::sqrt(count) >= sigmas;
  }
};

Pulls pulls_of(const char* name, std::span<const VehicleResult> vehicles) {
  Pulls pulls;
  double sum = 0.0;
  for (const VehicleResult& vehicle : vehicles) {
    if (vehicle.withheld || !vehicle.budget) continue;
    const auto pull = vehicle.budget->prior_pulls.find(name);
    if (pull == vehicle.budget->prior_pulls.end()) continue;
    ++pulls.count;
    sum += pull->second;
  }
  if (pulls.count > 0) pulls.mean = sum / pulls.count;
  return pulls;
}

bool drives(const SpeedEstimate& speed) {
  constexpr double kClear = 3.0;
  return speed.speed_mps > kClear * speed.std_mps;
}

double mean_acceleration_mps2(std::span<const VehicleResult> vehicles) {
  double sum = 0.0, count = 0.0;
  for (const VehicleResult& vehicle : vehicles) {
    if (vehicle.withheld || !vehicle.acceleration_mps2) continue;
    sum += *vehicle.acceleration_mps2;
    count += 1.0;
  }
  return sum / std::max(count, 1.0);
}

}  // namespace

std::vector<std::string> site_doubts(std::span<const VehicleResult> vehicles,
                                     const RoadSite& road) {
  std::vector<std::string> doubts;
  if (!road.lanes.empty()) {
    int drive = 0, in_none = 0;
    for (const VehicleResult& vehicle : vehicles) {
      if (vehicle.withheld || !vehicle.used_camera || !drives(vehicle.speed)) continue;
      ++drive;
      in_none += vehicle.lane.empty();
    }
    if (in_none > 1 && 2 * in_none > drive)
      doubts.push_back(std::to_string(in_none) + " of " + std::to_string(drive) +
                       " vehicles drive in none of the lanes told for their direction: check the "
                       "lanes' lateral_m and direction, and the camera's position_m, yaw_deg and "
                       "pitch_deg; their speeds may be off as well");
  }
  for (const Known& known : kOfEachVehicle) {
    const Pulls pulls = pulls_of(known.name, vehicles);
    if (!pulls.alike(2.0, 4.5)) continue;
    doubts.push_back("the lamps of " + std::to_string(pulls.count) + " vehicles come out " +
                     (pulls.mean > 0.0 ? known.larger : known.smaller) +
                     " than the site file says, by " + fixed_text(std::abs(pulls.mean), 1) +
                     " of its standard deviations on average, and their speeds are off with them: "
                     "check " +
                     known.facts);
  }
  // Where they stop or start again all do so.
  const Pulls accelerations = pulls_of("acceleration", vehicles);
  if (accelerations.alike(0.9, 2.5)) {
    const double mean_mps2 = mean_acceleration_mps2(vehicles);
    doubts.push_back(std::to_string(accelerations.count) + " vehicles seem to " +
                     (mean_mps2 > 0.0 ? "speed up" : "brake") + " by " +
                     fixed_text(std::abs(mean_mps2), 1) +
                     " m/s2 on average; where they do not, their speeds are off: check whether the "
                     "road bends as the site file says, and the camera's yaw_deg");
  }
  return doubts;
}

}  // namespace vildar
