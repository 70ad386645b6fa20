#include "pipelines/own_turns.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>

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
  double radius_m;  // where it turns most
};

// Of the part in which it turns at half the sharpest curvature or more, by seconds in which it
// drives: the noise of a yaw rate turns one that stands on the spot.
double radius_of(std::span<const DrivenPose> way) {
  constexpr std::size_t kSteps = 10;
  constexpr double kCreeping_m = 1.0;
  double sharpest_per_m = 0.0, turned_rad = 0.0, turning_m = 0.0;
  for (const bool sum : {false, true})
    for (std::size_t i = 0; i + kSteps < way.size(); ++i) {
      const double way_m = way[i + kSteps].way_m - way[i].way_m;
      const double rad = std::abs(way[i + kSteps].heading_rad - way[i].heading_rad);
      if (way_m < kCreeping_m) continue;
      if (!sum) {
        sharpest_per_m = std::max(sharpest_per_m, rad / way_m);
      } else if (rad >= 0.5 * sharpest_per_m * way_m) {
        turned_rad += rad;
        turning_m += way_m;
      }
    }
  return turning_m / turned_rad;
}

std::optional<OwnTurn> sharpest_turn(const EgoMotion& ego, Uncertain road_curvature_per_m,
                                     double from_s, double to_s) {
  constexpr double kSigmas = 2.5;
  std::vector<DrivenPose> way{{.time_s = from_s}};
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
  std::optional<OwnTurn> most;
  for (std::size_t first = 0; first + window <= way.size(); ++first) {
    const std::size_t last = first + window - quarter;
    const auto change = [&](double DrivenPose::*field) {
      return mean(last, field) - mean(first, field);
    };
    const double heading_rad = change(&DrivenPose::heading_rad), way_m = change(&DrivenPose::way_m);
    const double off_rad = heading_rad - road_curvature_per_m.mean * way_m;
    const double least_rad =
        std::max(kMost_rad, kAside_m / way_m) + kSigmas * road_curvature_per_m.std * way_m;
    if (std::abs(off_rad) > least_rad && (!most || std::abs(off_rad) > std::abs(most->off_rad)))
      most = {way[first].time_s,
              way[first + window - 1].time_s,
              off_rad,
              heading_rad,
              way_m,
              radius_of(std::span(way).subspan(first, window))};
  }
  return most;
}

std::string advice(const OwnTurn& turn, double road_curvature_per_m) {
  constexpr double kAlike = 0.3;
  const double road_rad = road_curvature_per_m * turn.way_m;
  if (std::abs(turn.heading_rad + road_rad) < kAlike * std::abs(road_rad))
    return "check the sign of the yaw rates (positive: to the left) and road.turn";
  if (std::abs(turn.heading_rad) < kMost_rad)
    return "write road.kind: straight where that is the road";
  return std::string("write road.kind: curved, turn: ") +
         (turn.heading_rad > 0.0 ? "left" : "right") +
         ", radius_m: " + fixed_text(turn.radius_m, 0) + " where that is the road, or cut the clip";
}

}  // namespace

std::vector<std::string> turns_off_the_road(const Site& site, double to_s) {
  // Where a bend begins ahead of a camera that drives is not known: that has a warning of its own.
  if (!site.ego || !site.ego->turns_known() || site.road.straight_m > 0.0) return {};
  Uncertain road_curvature_per_m;
  if (const auto& radius_m = site.road.radius_m)
    road_curvature_per_m = {bend_of(site.road) / radius_m->mean,
                            radius_m->std / (radius_m->mean * radius_m->mean)};
  const std::vector<EgoSample>& trace = site.ego->trace;
  const auto turn =
      sharpest_turn(EgoMotion(*site.ego, site.road), road_curvature_per_m,
                    std::max(0.0, trace.front().time_s), std::min(to_s, trace.back().time_s));
  if (!turn) return {};
  const auto degrees = [](double rad) {
    return fixed_text(std::abs(rad) * 180.0 / std::numbers::pi, 0);
  };
  return {site.file.string() + ": from " + fixed_text(turn->from_s, 1) + " to " +
          fixed_text(turn->to_s, 1) + " s of the clip the own vehicle turns by " +
          degrees(turn->heading_rad) + " degrees to the " +
          (turn->heading_rad > 0.0 ? "left" : "right") + " (yaw rates of the ego trace), " +
          degrees(turn->off_rad) +
          " degrees off the road stated: vehicles on a road that bends otherwise are withheld, or "
          "found beside it; " +
          advice(*turn, road_curvature_per_m.mean)};
}

}  // namespace vildar
