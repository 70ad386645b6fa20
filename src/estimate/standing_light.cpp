#include "estimate/standing_light.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/median.h"

namespace vildar {
namespace {

// By how much the lights moved in the picture, by the medians of the first and the last third.
double moved_px(const VehicleTrack& track) {
  const std::size_t third = std::max<std::size_t>(track.sightings.size() / 3, 1);
  const auto place = [&](std::size_t from) {
    std::vector<double> u_px, v_px;
    for (std::size_t k = from; k < from + third; ++k)
      for (const auto* lamp : {&track.sightings[k].left, &track.sightings[k].right})
        if (*lamp) {
          u_px.push_back((*lamp)->centre_px.x());
          v_px.push_back((*lamp)->centre_px.y());
        }
    return Eigen::Vector2d(median(std::move(u_px)), median(std::move(v_px)));
  };
  return (place(track.sightings.size() - third) - place(0)).norm();
}

}  // namespace

bool stands_all_the_time(const VehicleTrack& track, const Site& site, const Trajectory& trajectory,
                         const SpeedEstimate& speed) {
  constexpr double kStands_mps = 0.3, kSigmas = 1.5, kMostUnsure_mps = 1.0;
  constexpr double kWay_m = 4.0, kMostMoved_px = 20.0;  // a mast that sways
  if (site.ego) return false;
  const double way_m =
      trajectory.at(trajectory.from_s).range_m - trajectory.at(trajectory.to_s).range_m;
  return speed.std_mps < kMostUnsure_mps &&
         speed.speed_mps < kStands_mps + kSigmas * speed.std_mps && std::abs(way_m) < kWay_m &&
         moved_px(track) < kMostMoved_px;
}

bool may_be_a_post(const VehicleTrack& track, const Site& site, const SpeedEstimate& speed) {
  constexpr double kStands_mps = 0.3;
  return site.ego && !site.ego->stands() && track.single_lamp && speed.lo95_mps < kStands_mps;
}

}  // namespace vildar
