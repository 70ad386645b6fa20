#include "estimate/off_road.h"

#include <algorithm>
#include <cmath>

#include "core/text.h"
#include "estimate/lane_choice.h"

namespace vildar {
namespace {

// How far outside of the centre of the road's outermost lane, in widths of that; negative within.
double beside_outermost_lane(const Trajectory& trajectory, const Site& site) {
  const double at_m = trajectory.lateral_m();
  const auto centre_m = [](const LaneSite& lane) { return lane.lateral_m.mean; };
  const LaneSite& rightmost = std::ranges::min(site.road.lanes, {}, centre_m);
  const LaneSite& leftmost = std::ranges::max(site.road.lanes, {}, centre_m);
  const double right_m = centre_m(rightmost) - at_m, left_m = at_m - centre_m(leftmost);
  const LaneSite& outermost = right_m > left_m ? rightmost : leftmost;
  return std::max(right_m, left_m) / outermost.width_m;
}

// Whether lights would drive in a lane of their direction if they were `lowest_m` or more high, as
// marker lamps on a roof.
bool would_drive_on_a_roof(const Trajectory& trajectory, const Site& site, Direction direction,
                           double lowest_m) {
  constexpr double kHighest_m = 4.0, kLeastDrop_m = 0.3, kSigmas = 2.5;
  const auto& position_m = site.camera->position_m;
  const double drop_m =
      std::exp(trajectory.fit.parameters[kLogScale]) * trajectory.fit.parameters[kDrop];
  const double low_drop_m = std::max(position_m[2].mean - kHighest_m, kLeastDrop_m);
  const double high_drop_m = position_m[2].mean - lowest_m;
  if (!(low_drop_m < high_drop_m && high_drop_m < drop_m)) return false;
  const double aside_m = trajectory.lateral_m() - position_m[1].mean;
  const double low_m = aside_m * low_drop_m / drop_m, high_m = aside_m * high_drop_m / drop_m;
  return std::ranges::any_of(site.road.lanes, [&](const LaneSite& lane) {
    const Uncertain lane_m = lane_prior_m(lane);
    const double lane_aside_m = lane_m.mean - position_m[1].mean, slack_m = kSigmas * lane_m.std;
    return lane.direction == direction && lane_aside_m + slack_m > std::min(low_m, high_m) &&
           lane_aside_m - slack_m < std::max(low_m, high_m);
  });
}

// Whether it drives in a lane of the other direction though its own has lanes to overtake in.
bool against_the_traffic(const Trajectory& trajectory, const Site& site, Direction direction) {
  constexpr double kInLane = 0.5;  // of its width
  const auto own = std::ranges::count(site.road.lanes, direction, &LaneSite::direction);
  return own > 1 && std::ranges::any_of(site.road.lanes, [&](const LaneSite& lane) {
           return lane.direction != direction &&
                  std::abs(trajectory.lateral_m() - lane.lateral_m.mean) < kInLane * lane.width_m;
         });
}

// Of those beside the road's outermost lane, where no further lane can be, or against the traffic:
// between lanes one changes or overtakes. Of a row of lights anywhere but in a lane; a light bar is
// on a lower roof.
bool may_ride_on_a_roof(const VehicleTrack& track, const Trajectory& trajectory, const Site& site) {
  constexpr double kLorry_m = 2.5, kCar_m = 1.4;
  constexpr double kInLane = 0.35, kNextLane = 0.75;  // of a lane's width, from its centre
  const double beside = beside_outermost_lane(trajectory, site);
  const bool outside = beside >= kInLane && beside <= kNextLane;
  return (outside || track.lights_between ||
          against_the_traffic(trajectory, site, track.direction)) &&
         would_drive_on_a_roof(trajectory, site, track.direction,
                               track.lights_between ? kCar_m : kLorry_m);
}

// Farther from every lane of its direction than a lane beside it could be that the site file leaves
// out. A camera that drives has lanes by its own place.
bool beside_any_next_lane(const Trajectory& trajectory, const Site& site, Direction direction) {
  constexpr double kNextLane = 1.25;  // widths
  if (site.ego) return false;
  const PathVector& path = trajectory.fit.parameters;
  const double scale_m = std::exp(path[kLogScale]);
  PathVector slopes = PathVector::Zero();
  slopes[kLogScale] = scale_m * path[kLateral];
  slopes[kLateral] = scale_m;
  const double std_m = std::sqrt(std::max(0.0, slopes.dot(trajectory.fit.covariance * slopes)));
  return std::ranges::all_of(site.road.lanes, [&](const LaneSite& lane) {
    return lane.direction != direction || std::abs(trajectory.lateral_m() - lane.lateral_m.mean) >
                                              kNextLane * lane.width_m + std_m;
  });
}

}  // namespace

bool in_no_lane(const VehicleTrack& track, const Site& site,
                std::span<const Trajectory> trajectories) {
  constexpr double kLikelier = 0.5, kEdge = 0.5, kBesideNextLane = 0.75;
  if (std::ranges::none_of(site.road.lanes,
                           [&](const LaneSite& lane) { return lane.direction == track.direction; }))
    return false;
  const auto is_elsewhere = [&](const Trajectory& one) {
    const double beside = beside_outermost_lane(one, site);
    if (track.single_lamp) return one.lane.empty() || beside > kEdge;
    if (!one.lane.empty()) return false;
    return (one.part && beside > kBesideNextLane) ||
           beside_any_next_lane(one, site, track.direction) || may_ride_on_a_roof(track, one, site);
  };
  double in_none = 0.0;
  for (const Trajectory& one : trajectories)
    if (is_elsewhere(one)) in_none += one.weight;
  return in_none > kLikelier;
}

std::string beside_the_lanes(double lateral_m) {
  return "it drives at y = " + fixed_text(lateral_m, 1) +
         " m, beside the lanes of the site file: check the signs of their lateral_m, road.kind and "
         "the camera's yaw, or add its lane (marker lamps on a roof seem to drive elsewhere)";
}

}  // namespace vildar
