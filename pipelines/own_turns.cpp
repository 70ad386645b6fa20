#include "pipelines/own_turns.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/text.h"
#include "optics/ego_motion.h"
#include "optics/road.h"

namespace vildar {
namespace {

constexpr double kStep_s = 0.1, kWindow_s = 8.0, kMost_rad = 0.15;
constexpr double kAside_m = 14.0;  // over its way: more than one turns who changes lanes slowly

// How far the own vehicle turns from the first to the last quarter of a stretch of its way.
struct OwnTurn {
  double from_s, to_s, off_rad, heading_rad, way_m;
};

OwnTurn sharpest_turn(const EgoMotion& ego, double road_curvature_per_m, double to_s) {
  std::vector<DrivenPose> way{{.time_s = 0.0}};
  while (way.back().time_s < to_s)
    way.push_back(ego.driven(way.back(), std::min(to_s, way.back().time_s + kStep_s)));
  const std::size_t window =
      std::min(way.size(), static_cast<std::size_t>(std::lround(kWindow_s / kStep_s)) + 1);
  const std::size_t quarter = std::max<std::size_t>(window / 4, 1);
  const auto mean = [&](std::size_t first, double DrivenPose::*field) {
    double sum = 0.0;
    for (std::size_t i = first; i < first + quarter; ++i) sum += way[i].*field;
    return sum / static_cast<double>(quarter);
  };
  OwnTurn most{};
  for (std::size_t first = 0; first + window <= way.size(); ++first) {
    const std::size_t last = first + window - quarter;
    const auto change = [&](double DrivenPose::*field) {
      return mean(last, field) - mean(first, field);
    };
    const double heading_rad = change(&DrivenPose::heading_rad), way_m = change(&DrivenPose::way_m);
    const double off_rad = heading_rad - road_curvature_per_m * way_m;
    if (std::abs(off_rad) > std::max(kMost_rad, kAside_m / way_m) &&
        std::abs(off_rad) > std::abs(most.off_rad))
      most = {way[first].time_s, way[first + window - 1].time_s, off_rad, heading_rad, way_m};
  }
  return most;
}

}  // namespace

std::vector<std::string> turns_off_the_road(const Site& site, double to_s) {
  if (!site.ego || !site.ego->turns_known()) return {};
  const double road_curvature_per_m =
      site.road.radius_m ? bend_of(site.road) / site.road.radius_m->mean : 0.0;
  const OwnTurn turn = sharpest_turn(EgoMotion(*site.ego, site.road), road_curvature_per_m, to_s);
  if (turn.off_rad == 0.0) return {};
  const auto degrees = [](double rad) {
    return fixed_text(std::abs(rad) * 180.0 / std::numbers::pi, 0);
  };
  const std::string side = turn.heading_rad > 0.0 ? "left" : "right";
  const std::string road = std::abs(turn.heading_rad) < kMost_rad
                               ? "road.kind: straight"
                               : "road.kind: curved, turn: " + side + ", radius_m: " +
                                     fixed_text(turn.way_m / std::abs(turn.heading_rad), 0);
  return {site.file.string() + ": from " + fixed_text(turn.from_s, 1) + " to " +
          fixed_text(turn.to_s, 1) + " s of the clip the own vehicle turns by " +
          degrees(turn.heading_rad) + " degrees to the " + side +
          " (yaw rates of the ego trace), " + degrees(turn.off_rad) +
          " degrees off the road stated: vehicles on a road that bends otherwise are withheld, or "
          "found beside it; write " +
          road + " where that is the road, or cut the clip"};
}

}  // namespace vildar
