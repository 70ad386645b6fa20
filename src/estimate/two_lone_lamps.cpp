#include "estimate/two_lone_lamps.h"

#include <algorithm>
#include <cmath>

#include "core/clock.h"
#include "estimate/vehicle.h"

namespace vildar {
namespace {

constexpr double kSeenAlone_s = 0.6;  // a lone lamp is followed for so long, see TrackOptions

bool unexplained(const VehicleTrack& pair, const VehicleResult& found) {
  if (!found.withheld || pair.single_lamp || pair.ambiguous_identity || pair.lamps_go_on ||
      pair.direction_contradicts || pair.beside_lanes_m)
    return false;
  return *found.withheld == Miss::bad_fit || *found.withheld == Miss::not_on_road ||
         *found.withheld == Miss::ambiguous_identity;
}

bool long_enough(const VehicleTrack& lamp) {
  return !lamp.sightings.empty() &&
         seconds_of(lamp.sightings.back().time) - seconds_of(lamp.sightings.front().time) >=
             kSeenAlone_s;
}

// Whether one is ahead of the other as two vehicles are that follow each other, in all of the time
// that both are known in. Lamps at two heights of one body, and a lamp and its image, keep the
// ratio of their ranges.
bool follow_each_other(const Trajectory& one, const Trajectory& other) {
  constexpr double kLeastGap_m = 5.0, kLeastRatioChange = 0.1;
  const double from_s = std::max(one.from_s, other.from_s);
  const double to_s = std::min(one.to_s, other.to_s);
  if (to_s - from_s < kSeenAlone_s) return false;
  const auto gap_m = [&](double time_s) {
    return one.at(time_s).range_m - other.at(time_s).range_m;
  };
  const auto ratio_ln = [&](double time_s) {
    return std::log(one.at(time_s).range_m / other.at(time_s).range_m);
  };
  return std::min(std::abs(gap_m(from_s)), std::abs(gap_m(to_s))) > kLeastGap_m &&
         gap_m(from_s) * gap_m(to_s) > 0.0 &&
         std::abs(ratio_ln(from_s) - ratio_ln(to_s)) > kLeastRatioChange;
}

}  // namespace

std::pair<VehicleTrack, VehicleTrack> lamps_alone(const VehicleTrack& pair) {
  const auto alone = [&](std::optional<LampSighting> VehicleSighting::*side) {
    VehicleTrack lamp = pair;
    lamp.single_lamp = true;
    lamp.sightings.clear();
    for (const VehicleSighting& sighting : pair.sightings)
      if (sighting.*side && !sighting.both_in_one)
        lamp.sightings.push_back({sighting.frame, sighting.time, sighting.*side, std::nullopt});
    return lamp;
  };
  return {alone(&VehicleSighting::left), alone(&VehicleSighting::right)};
}

std::optional<std::pair<VehicleTrack, VehicleTrack>> two_lone_lamps(const VehicleTrack& pair,
                                                                    const VehicleResult& found,
                                                                    const Site& site) {
  if (site.ego || !unexplained(pair, found)) return std::nullopt;
  auto lamps = lamps_alone(pair);
  if (!long_enough(lamps.first) || !long_enough(lamps.second)) return std::nullopt;
  const VehicleEstimate left = estimate_vehicle(lamps.first, site, {});
  if (left.result.withheld) return std::nullopt;
  const VehicleEstimate right = estimate_vehicle(lamps.second, site, {});
  if (right.result.withheld ||
      !follow_each_other(left.trajectories.front(), right.trajectories.front()))
    return std::nullopt;
  return lamps;
}

}  // namespace vildar
