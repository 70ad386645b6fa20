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

struct Arc {
  double radius_m, speed_mps;
};

// How far the own vehicle turns from the first to the last quarter of a stretch of its way.
struct OwnTurn {
  double from_s, to_s, off_rad, heading_rad, way_m;
  std::optional<Arc> arc;  // where it turns most
};

// Of the part that turns it most of those in which it turns at half the sharpest curvature or more,
// by whole seconds in which it drives: the noise of a yaw rate turns one that stands or creeps. The
// second in which a turn begins has half its curvature when it is half in it, so the turn goes from
// middle to middle.
std::optional<Arc> sharpest_arc(std::span<const DrivenPose> way) {
  constexpr std::size_t kSteps = 10;
  constexpr double kStands_m = 1.0, kCreeps = 0.5;  // of the mean way of a second
  if (way.size() <= kSteps) return std::nullopt;
  const double mean_m = (way.back().way_m - way.front().way_m) /
                        static_cast<double>(way.size() - 1) * static_cast<double>(kSteps);
  const double least_m = std::max(kStands_m, kCreeps * mean_m);
  std::vector<double> curvature_per_m;  // of the seconds by their beginnings; 0 where it creeps
  for (std::size_t i = 0; i + kSteps < way.size(); ++i) {
    const double way_m = way[i + kSteps].way_m - way[i].way_m;
    const double rad = way[i + kSteps].heading_rad - way[i].heading_rad;
    curvature_per_m.push_back(way_m < least_m ? 0.0 : rad / way_m);
  }
  double sharpest_per_m = 0.0;
  for (const double one : curvature_per_m) sharpest_per_m = std::max(sharpest_per_m, std::abs(one));
  const auto turns = [&](std::size_t i) {
    return i < curvature_per_m.size() && std::abs(curvature_per_m[i]) > 0.5 * sharpest_per_m;
  };
  std::optional<Arc> sharpest;
  double most_rad = 0.0;
  for (std::size_t first = 0; first < curvature_per_m.size(); ++first) {
    if (!turns(first)) continue;
    std::size_t last = first;
    while (turns(last + 1)) ++last;
    const DrivenPose& from = way[first + kSteps / 2];
    const DrivenPose& to = way[last + kSteps / 2];
    const double rad = std::abs(to.heading_rad - from.heading_rad);
    if (rad > most_rad) {
      most_rad = rad;
      const double way_m = to.way_m - from.way_m;
      sharpest = Arc{way_m / rad, way_m / std::max(kStep_s, to.time_s - from.time_s)};
    }
    first = last;
  }
  return sharpest;
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
              sharpest_arc(std::span(way).subspan(first, window))};
  }
  return most;
}

std::string advice(const OwnTurn& turn, double road_curvature_per_m) {
  constexpr double kAlike = 0.3;
  constexpr double kNobodyTurnsSo_mps2 = 5.0;
  const double road_rad = road_curvature_per_m * turn.way_m;
  if (std::abs(turn.heading_rad + road_rad) < kAlike * std::abs(road_rad))
    return "check the sign of the yaw rates (positive: to the left) and road.turn";
  if (std::abs(turn.heading_rad) < kMost_rad)
    return "write road.kind: straight where that is the road";
  if (turn.arc &&
      turn.arc->speed_mps * turn.arc->speed_mps > kNobodyTurnsSo_mps2 * turn.arc->radius_m)
    return "that is " + fixed_text(turn.arc->radius_m, 0) + " m of radius at " +
           fixed_text(turn.arc->speed_mps, 0) +
           " m/s, sharper than cars are driven: check that yaw rates are in radians per second "
           "(degrees times 0.01745)";
  std::string road =
      std::string("write road.kind: curved, turn: ") + (turn.heading_rad > 0.0 ? "left" : "right");
  if (turn.arc) road += ", radius_m: " + fixed_text(turn.arc->radius_m, 0);
  return road + " where that is the road, or cut the clip";
}

}  // namespace

std::vector<std::string> turns_off_the_road(const Site& site, double to_s) {
  // Where a bend begins ahead of a camera that drives is not known: that has a warning of its own.
  if (!site.ego || !site.ego->turns_known() || site.road.straight_m.mean > 0.0) return {};
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
  return {site.ego->trace_path.string() + ": from " + fixed_text(turn->from_s, 1) + " to " +
          fixed_text(turn->to_s, 1) + " s of the clip the own vehicle turns by " +
          degrees(turn->heading_rad) + " degrees to the " +
          (turn->heading_rad > 0.0 ? "left" : "right") + " (yaw rates of the ego trace), " +
          degrees(turn->off_rad) +
          " degrees off the road stated: vehicles on a road that bends otherwise are withheld, or "
          "found beside it; " +
          advice(*turn, road_curvature_per_m.mean)};
}

}  // namespace vildar
