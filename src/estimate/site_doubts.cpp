#include "estimate/site_doubts.h"

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

}  // namespace

std::vector<std::string> site_doubts(std::span<const VehicleResult> vehicles) {
  constexpr int kFewest = 3;
  constexpr double kLeastMean = 2.0, kSigmas = 4.5;
  std::vector<std::string> doubts;
  for (const Known& known : kOfEachVehicle) {
    int count = 0;
    double sum = 0.0;
    for (const VehicleResult& vehicle : vehicles) {
      if (vehicle.withheld || !vehicle.budget) continue;
      const auto pull = vehicle.budget->prior_pulls.find(known.name);
      if (pull == vehicle.budget->prior_pulls.end()) continue;
      ++count;
      sum += pull->second;
    }
    if (count < kFewest) continue;
    const double mean = sum / count;
    if (std::abs(mean) < kLeastMean || std::abs(mean) * std::sqrt(count) < kSigmas) continue;
    doubts.push_back("the lamps of " + std::to_string(count) + " vehicles come out " +
                     (mean > 0.0 ? known.larger : known.smaller) + " than the site file says, by " +
                     fixed_text(std::abs(mean), 1) +
                     " of its standard deviations on average, and their speeds are off with them: "
                     "check " +
                     known.facts);
  }
  return doubts;
}

}  // namespace vildar
