#include "track/tracker.h"

namespace vildar {

std::vector<std::string> TrackOptions::problems() const {
  std::vector<std::string> found;
  const auto require = [&](bool holds, const char* field, double value, const char* rule) {
    if (!holds)
      found.push_back(std::string(field) + " = " + std::to_string(value) + ", must be " + rule);
  };
  require(longest_gap_s > 0.0 && longest_gap_s <= 5.0, "longest_gap_s", longest_gap_s, "in (0, 5]");
  require(min_sightings >= 2, "min_sightings", min_sightings, ">= 2");
  require(min_duration_s >= 0.0, "min_duration_s", min_duration_s, ">= 0");
  require(min_single_lamp_s >= 0.0, "min_single_lamp_s", min_single_lamp_s, ">= 0");
  require(gate_chi2 > 0.0, "gate_chi2", gate_chi2, "> 0");
  return found;
}

}  // namespace vildar
