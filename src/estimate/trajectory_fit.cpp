#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/clock.h"
#include "core/quantity.h"
#include "core/text.h"
#include "estimate/bearing_fit.h"
#include "estimate/driving_part.h"
#include "estimate/flashers.h"
#include "estimate/half_hidden.h"
#include "estimate/hypotheses.h"
#include "estimate/off_road.h"
#include "estimate/speed_budget.h"
#include "estimate/speed_gate.h"
#include "estimate/wander.h"
#include "optics/ego_motion.h"
#include "optics/road.h"

namespace vildar {
namespace {

// A part of a track, as shares of its time.
struct Part {
  double from, to;

  double length() const { return to - from; }
};

VehicleTrack part_of(const VehicleTrack& track, const Part& part) {
  const double from_s = seconds_of(track.sightings.front().time);
  const double length_s = seconds_of(track.sightings.back().time) - from_s;
  VehicleTrack cut = track;
  std::erase_if(cut.sightings, [&](const VehicleSighting& sighting) {
    const double share = (seconds_of(sighting.time) - from_s) / length_s;
    return share < part.from || share > part.to;
  });
  return cut;
}

// Turns of the camera's own vehicle that nobody tells are followed for so long alone, see
// kOwnSwings: of a vehicle that is longer ahead the part in which it is nearest, as its lamps'
// separation tells, or of a lone lamp the light.
constexpr double kOwnTurnsFollowed_s = 6.0;

double nearness(const VehicleSighting& sighting, bool single_lamp) {
  if (sighting.left && sighting.right)
    return (sighting.right->centre_px - sighting.left->centre_px).squaredNorm();
  const auto& lamp = sighting.left ? sighting.left : sighting.right;
  return single_lamp && lamp ? lamp->flux : 0.0;
}

std::optional<VehicleTrack> nearest_part(const VehicleTrack& track, const Site& site) {
  const auto& seen = track.sightings;
  if (!site.ego || track.direction != Direction::receding || seen.empty()) return std::nullopt;
  if ((site.ego->trace.empty() && site.ego->speed_mps.mean <= 0.0) ||
      turns_told(*site.ego, site.road,
                 {{seconds_of(seen.front().time), seconds_of(seen.back().time)}, true}))
    return std::nullopt;
  const auto length_s = [](auto from, auto to) {
    return seconds_of(to->time) - seconds_of(from->time);
  };
  if (length_s(seen.begin(), seen.end() - 1) <= kOwnTurnsFollowed_s) return std::nullopt;
  double sum = 0.0, most = 0.0;
  auto from = seen.begin(), best_from = from, best_to = from;
  for (auto to = seen.begin(); to != seen.end(); ++to) {
    sum += nearness(*to, track.single_lamp);
    for (; length_s(from, to) > kOwnTurnsFollowed_s; ++from)
      sum -= nearness(*from, track.single_lamp);
    if (sum < most) continue;
    most = sum;
    best_from = from;
    best_to = to;
  }
  VehicleTrack part = track;
  part.sightings.assign(best_from, best_to + 1);
  return part;
}

// What was seen while a trace of the own speed tells it; nothing where that is all.
std::optional<VehicleTrack> told_part(const VehicleTrack& track, const Site& site) {
  constexpr double kBeyond_s = 0.15;
  if (!site.ego || site.ego->trace.empty()) return std::nullopt;
  const double from_s = site.ego->trace.front().time_s - kBeyond_s;
  const double to_s = site.ego->trace.back().time_s + kBeyond_s;
  VehicleTrack part = track;
  const auto left_out = std::erase_if(part.sightings, [&](const VehicleSighting& sighting) {
    const double time_s = seconds_of(sighting.time);
    return time_s < from_s || time_s > to_s;
  });
  return left_out > 0 ? std::optional(std::move(part)) : std::nullopt;
}

// Yaw rates that turn the own vehicle about as much as the road, but the other way.
bool turns_against_the_road(const Site& site, const VehicleTrack& track) {
  constexpr double kLeast_rad = 0.1, kLeastShare = 0.5, kMostShare = 2.0;
  const RoadSite& road = site.road;
  if (track.sightings.empty() || !site.ego || !site.ego->turns_known() ||
      road.kind != RoadKind::curved || !road.radius_m || road.straight_m.mean > 0.0)
    return false;
  DrivenPose start;
  start.time_s = seconds_of(track.sightings.front().time);
  const DrivenPose end =
      EgoMotion(*site.ego, road).driven(start, seconds_of(track.sightings.back().time));
  const double road_rad = bend_of(road) / road.radius_m->mean * end.way_m;
  return std::abs(road_rad) > kLeast_rad && end.heading_rad * road_rad < 0.0 &&
         std::abs(end.heading_rad) > kLeastShare * std::abs(road_rad) &&
         std::abs(end.heading_rad) < kMostShare * std::abs(road_rad);
}

// One ahead of a vehicle that turns off as no road does but a crossing may turn there, too, before.
bool at_a_corner(const Site& site, const VehicleTrack& track) {
  constexpr double kAround_s = 3.0, kSharpest_m = 25.0, kSlow_mps = 2.0, kTurn_rad = 0.35;
  if (track.sightings.empty() || !site.ego || track.direction != Direction::receding) return false;
  const double from_s = seconds_of(track.sightings.front().time) - kAround_s;
  const double to_s = seconds_of(track.sightings.back().time) + kAround_s;
  double turned_rad = 0.0;
  const std::vector<EgoSample>& trace = site.ego->trace;
  for (std::size_t i = 1; i < trace.size(); ++i) {
    const EgoSample& now = trace[i];
    const bool sharply = std::abs(now.yaw_rate_rad_per_s) * kSharpest_m >
                         std::max(std::abs(now.speed_mps), kSlow_mps);
    if (now.time_s > from_s && now.time_s < to_s && sharply)
      turned_rad += now.yaw_rate_rad_per_s * (now.time_s - trace[i - 1].time_s);
  }
  return std::abs(turned_rad) > kTurn_rad;
}

// Lone lights before a pair may be another vehicle's, or glints: what both lamps were seen in
// counts.
double share_of_pairs(const VehicleTrack& part, const VehicleTrack& track) {
  const auto pairs = [](const VehicleTrack& of) {
    return std::ranges::count_if(of.sightings, [](const VehicleSighting& sighting) {
      return sighting.left && sighting.right;
    });
  };
  const auto all = pairs(track);
  return all > 0 ? static_cast<double>(pairs(part)) / static_cast<double>(all) : 1.0;
}

double relative_sigma(const Trajectory& trajectory) {
  const MotionState state =
      trajectory.at(best_time_s(trajectory, trajectory.from_s, trajectory.to_s));
  return state.speed_std_mps / std::abs(state.over_ground_mps);
}

struct SteadyPart {
  double length;  // share of the track's time
  double pairs;   // share of what both lamps were seen in
  BearingFit fit;

  // Less than half a track proves nothing, but may disprove a longer part.
  bool proves() const { return length > 0.49 && pairs >= 0.5; }
};

// The parts of a track that the model explains, the longest first: a lamp was hidden or another's
// for a while, or the vehicle began to brake.
std::vector<SteadyPart> steady_parts(const VehicleTrack& track, const Camera& camera,
                                     const Site& site) {
  constexpr int kFewestFrames = 12;
  constexpr double kLeastPairs = 0.333;
  constexpr std::array<Part, 8> kLongestFirst{{{0.0, 0.667},
                                               {0.333, 1.0},
                                               {0.0, 0.5},
                                               {0.25, 0.75},
                                               {0.5, 1.0},
                                               {0.0, 0.333},
                                               {0.333, 0.667},
                                               {0.667, 1.0}}};
  std::vector<SteadyPart> found;
  for (const Part& part : kLongestFirst) {
    const VehicleTrack cut = part_of(track, part);
    const double pairs = share_of_pairs(cut, track);
    if (pairs < kLeastPairs) continue;
    auto outcome = fit_bearings(cut, camera, site);
    BearingFit* fit = std::get_if<BearingFit>(&outcome);
    if (!fit || !fit->steady() || fit->trajectory.frames < kFewestFrames) continue;
    found.push_back({part.length(), pairs, std::move(*fit)});
  }
  return found;
}

constexpr double kDoubtful = 2.0;       // growth of the sigmas by what a fit leaves
constexpr double kMostStrained = 25.0;  // chi-square of up to ten priors
constexpr double kMostLeft = 3.0;       // the same, of one that claims to explain a track

struct LaneChange {
  std::optional<BearingFit> fit;
  bool but_unlikely = false;  // there is one that explains far more, of no likely lengths and pose
};

// A pair that changes lanes, where that explains more than a fit in one lane, which leaves its
// sigmas to grow by so much, and lengths and pose are likely ones: what may go anywhere can pass
// for a toy. Of one ahead of a camera that drives, of whose way not all is known, it need not
// explain all, but must leave far less.
LaneChange changes_lanes(const VehicleTrack& track, const Camera& camera, const Site& site,
                         double in_lane_factor) {
  constexpr double kFarLess = 0.5, kFarBetter = 0.1;
  if (track.single_lamp) return {};
  auto outcome = fit_lane_change(track, camera, site);
  BearingFit* fit = std::get_if<BearingFit>(&outcome);
  if (!fit) return {};
  const double factor = fit->check.sigma_factor.maxCoeff();
  const bool ahead = site.ego && track.direction == Direction::receding;
  const bool better = ahead && factor > kDoubtful
                          ? fit->explains() && factor < kFarLess * in_lane_factor
                          : fit->steady() && factor < in_lane_factor &&
                                fit->trajectory.fit.prior_chi2 < kMostStrained;
  if (better) return {std::move(*fit)};
  return {{}, fit->explains() && factor < kFarBetter * in_lane_factor};
}

// Before any camera that stands, one who weaves in his lane, where that explains all but all that
// else is left in both axes and lengths and pose are likely ones. A camera that sways leaves some,
// upright most of all.
std::optional<BearingFit> weaves(const VehicleTrack& track, const Camera& camera, const Site& site,
                                 double in_line_factor) {
  constexpr double kFarLess = 0.5;
  auto outcome = fit_bearings(track, camera, site, Weave::allowed);
  BearingFit* fit = std::get_if<BearingFit>(&outcome);
  if (!fit || !fit->trajectory.problem.setting.weaves || !fit->steady() ||
      fit->trajectory.fit.prior_chi2 > kMostStrained ||
      fit->check.sigma_factor.maxCoeff() > std::min(kMostLeft, kFarLess * in_line_factor))
    return std::nullopt;
  return std::move(*fit);
}

// Beside a bend, whatever lamps it has: with lengths of another class a way in one lane looks like
// one that leaves it.
bool leaves_lane(const BearingFit& first, const Site& site) {
  return first.leaves_lane() &&
         std::ranges::all_of(first.readings, [&](const LampReading& reading) {
           BearingFit other = first;
           GeometryProblem& problem = other.trajectory.problem;
           const Uncertain acceleration_mps2 = problem.priors.acceleration_mps2;
           problem.priors = metric_priors(site, reading);
           problem.priors.acceleration_mps2 = acceleration_mps2;
           const auto outcome = fit_geometry(problem, first.trajectory.fit.parameters);
           const auto* fit = std::get_if<GeometryFit>(&outcome);
           if (!fit) return true;
           other.trajectory.fit = *fit;
           return other.leaves_lane();
         });
}

// The surest of the longest that prove something, if any.
BearingFit* best_of(std::vector<SteadyPart>& parts) {
  SteadyPart* best = nullptr;
  for (SteadyPart& one : parts) {
    if (!one.proves()) continue;
    if (best && (one.length < best->length - 0.01 ||
                 relative_sigma(one.fit.trajectory) > relative_sigma(best->fit.trajectory)))
      continue;
    best = &one;
  }
  return best ? &best->fit : nullptr;
}

bool holds(const Trajectory& longer, const Trajectory& part) {
  return longer.from_s <= part.from_s && part.to_s <= longer.to_s;
}

struct Discord {
  double sigmas = 0.0;  // by what the two state of themselves
  bool excludes = false;
};

// By the shapes at the time between the two: the scale is that of the same lengths in both, and so
// is the own speed.
Discord discord(const Trajectory& one, const Trajectory& other) {
  // Coding and clipping draw centres aside for longer than a part lasts.
  constexpr double kCoding = 0.01, kLeast = 0.001;  // of the speed
  // So much a steady acceleration leaves where braking sets in or ends within a part.
  constexpr double kOnset_mps = 0.2;
  if (one.problem.pairs != other.problem.pairs) return {};
  const double time_s = 0.5 * (std::max(one.from_s, other.from_s) + std::min(one.to_s, other.to_s));
  const auto told_by = [&](const Trajectory& of) {
    const double speed_mps = of.at(time_s).over_ground_mps;
    const double shape_mps = speed_budget(of, time_s).shape * speed_mps;
    const double own_mps = of.common_std_mps(time_s);
    const double own_shape_mps =
        std::sqrt(std::max(0.0, shape_mps * shape_mps - own_mps * own_mps));
    return PartSpeed{speed_mps, std::max(own_shape_mps, kLeast * std::abs(speed_mps))};
  };
  PartSpeed a = told_by(one), b = told_by(other);
  const bool nested = holds(one, other) || holds(other, one);
  Discord found{sigmas_apart(a, b, nested)};
  for (PartSpeed* part : {&a, &b})
    part->sigma_mps = std::hypot(part->sigma_mps, kCoding * part->speed_mps, kOnset_mps);
  found.excludes = exclude_each_other(a, b, nested);
  return found;
}

// Lamps of a vehicle stand level, but for the road's crossfall, of which a dashcam's own vehicle
// has its own, and go on as they stand. Of two that stand one behind the other the nearer is seen
// lower, and together they move as no vehicle of such a size is likely to. Says how they stand.
std::optional<std::string> of_two_vehicles(const Trajectory& likeliest,
                                           const ResidualCheck& check) {
  constexpr double kMostTilt = 8.0, kTilted = 2.5, kMostStrain = 16.0;  // of chi-square
  const GeometryProblem& problem = likeliest.problem;
  if (!problem.pairs) return std::nullopt;
  // Usual is 0.025; a bend may be banked.
  const bool banked = problem.setting.bend != 0.0 && !likeliest.ego.moving();
  const double crossfall_rad = banked ? 0.06 : 0.03;
  // From above a vehicle that turns turns its line, too.
  constexpr double kHeading_rad = 0.1;
  const double nearest_m =
      std::min(likeliest.at(likeliest.from_s).range_m, likeliest.at(likeliest.to_s).range_m);
  const double from_above =
      (problem.setting.camera_m.z() - likeliest.lamp_height_m()) / std::max(nearest_m, 1.0);
  const double change_rad = std::hypot(banked ? 0.04 : 0.02, kHeading_rad * from_above);
  const MetricPriors& priors = problem.priors;
  const double roll_std_rad = priors.turn_rad[2].std;
  const auto chi2 = [](const Uncertain& value, double expected_std) {
    return value.mean * value.mean / (value.std * value.std + expected_std * expected_std);
  };
  const double stands = chi2(check.tilt_rad, std::hypot(crossfall_rad, roll_std_rad));
  const double turns = chi2(check.tilt_change_rad, change_rad);
  // What the fit took for roll is part of the tilt.
  double strain = likeliest.fit.prior_chi2;
  if (roll_std_rad > 0.0) strain -= std::pow(likeliest.fit.parameters[kRoll] / roll_std_rad, 2);
  const double rate = likeliest.at(problem.reference_s).acceleration_mps2;
  const double braking = rate * rate / kAccelerationVariance_m2ps4;
  const double tilt = stands + turns;
  if (tilt <= kMostTilt && (tilt <= kTilted || tilt + std::max(strain, braking) <= kMostStrain))
    return std::nullopt;
  const Uncertain& shown = turns > stands ? check.tilt_change_rad : check.tilt_rad;
  return "the line through its lamps " + std::string(turns > stands ? "turns by " : "is ") +
         fixed_text(degrees_from_radians(std::abs(shown.mean)), 1) +
         (turns > stands ? " degrees in view" : " degrees off the level") +
         ": they may be of two vehicles";
}

}  // namespace

Outcome<std::vector<Trajectory>> fit_trajectories(const VehicleTrack& as_seen, const Camera& camera,
                                                  const Site& site,
                                                  std::vector<std::string>& warnings) {
  if (!site.ego && lit_in_turn(as_seen)) {
    warnings.push_back(
        "its light stands still and goes on elsewhere: taken for lamps that are lit one after "
        "another");
    return Miss::not_on_road;
  }
  const VehicleTrack whole = without_half_hidden(without_flashes(as_seen));
  if (whole.beside_lanes_m) {
    warnings.push_back(beside_the_lanes(*whole.beside_lanes_m));
    return Miss::not_on_road;
  }
  const auto told = told_part(whole, site);
  if (told && told->sightings.empty()) {
    warnings.push_back(
        "the ego trace does not tell the own speed while the vehicle is seen; record it over the "
        "whole clip");
    return Miss::too_few_samples;
  }
  const auto nearest = nearest_part(told ? *told : whole, site);
  const auto driving = driving_part(whole, camera, site);
  const VehicleTrack& track = nearest ? *nearest : told ? *told : driving ? *driving : whole;
  const auto measured_alone = [](double from_s, double to_s) {
    return "measured from " + fixed_text(from_s, 2) + " to " + fixed_text(to_s, 2) + " s alone";
  };
  if (told && !nearest)
    warnings.push_back(
        "the ego trace does not tell the own speed all the while the vehicle is seen: " +
        measured_alone(seconds_of(told->sightings.front().time),
                       seconds_of(told->sightings.back().time)));
  if (nearest)
    warnings.push_back(
        "followed for longer than the own vehicle's turns can be without yaw rates: " +
        measured_alone(seconds_of(track.sightings.front().time),
                       seconds_of(track.sightings.back().time)));
  if (driving)
    warnings.push_back("it stands for a while in view: " +
                       measured_alone(seconds_of(track.sightings.front().time),
                                      seconds_of(track.sightings.back().time)));
  if (turns_against_the_road(site, track)) {
    warnings.push_back(
        "the ego trace's yaw rates turn the other way than the road: they are positive to the "
        "left; "
        "check their sign and road.turn");
    return Miss::not_on_road;
  }
  if (at_a_corner(site, track)) {
    warnings.push_back(
        "the own vehicle turns off (ego trace) within 3 s of it: one ahead may have turned there "
        "before, along a way that no road of the site file tells");
    return Miss::not_on_road;
  }
  const bool ahead = site.ego && track.direction == Direction::receding;
  auto outcome = fit_bearings(track, camera, site);
  bool leaves_unlike_any = false;
  const auto in_another_lane = [&](double in_lane_factor) {
    auto [changing, but_unlikely] = changes_lanes(track, camera, site, in_lane_factor);
    leaves_unlike_any |= but_unlikely;
    if (!changing) return false;
    warnings.push_back(changing->trajectory.problem.setting.bend != 0.0
                           ? "it leaves the line of its lane in view"
                           : "it changes lanes in view");
    outcome = std::move(*changing);
    return true;
  };
  if (const Miss* miss = std::get_if<Miss>(&outcome);
      miss && !((ahead || !site.ego) && *miss == Miss::not_converged && in_another_lane(INFINITY)))
    return *miss;
  BearingFit& first = std::get<BearingFit>(outcome);
  const double factor = first.check.sigma_factor.maxCoeff();
  const bool doubtful = !first.steady() || factor > kDoubtful;
  // One that wanders on a bend looks steady and slower or faster than it is.
  const bool leaves = leaves_lane(first, site);
  const bool crosses = (leaves && in_another_lane(INFINITY)) ||
                       (ahead && doubtful && !first.told_apart() && in_another_lane(factor));
  if (leaves && !crosses && first.steady()) {
    warnings.push_back(
        "it leaves the line of its lane as no change of lanes explains: check the "
        "bend's radius and where it begins");
    return Miss::bad_fit;
  }
  if (!crosses && doubtful && !site.ego && !first.trajectory.problem.setting.weaves)
    if (auto weaving = weaves(track, camera, site, factor)) first = std::move(*weaving);
  if (!crosses && !first.steady() && (site.ego || !in_another_lane(std::min(factor, kMostLeft)))) {
    auto parts = steady_parts(track, camera, site);
    BearingFit* best = best_of(parts);
    const bool untried = site.ego ? !ahead : factor > kMostLeft;
    if (!best && !(untried && in_another_lane(factor))) {
      if (!first.explains()) return Miss::bad_fit;
      if (leaves_unlike_any && !site.ego) {
        warnings.push_back(
            "it leaves the line of its lane in view, as no likely lamps and pose explain");
        return Miss::bad_fit;
      }
    }
    if (best) {
      Discord most;
      for (const SteadyPart& one : parts) {
        if (&one.fit == best) continue;
        const Discord found = discord(best->trajectory, one.fit.trajectory);
        most = {std::max(most.sigmas, found.sigmas), most.excludes || found.excludes};
      }
      if (most.excludes) {
        warnings.push_back(
            "parts of its track exclude each other: its lamps may be of two vehicles");
        return Miss::ambiguous_identity;
      }
      first = std::move(*best);
      first.trajectory.part = true;
      constexpr double kByChance = 2.5;  // of up to seven parts
      if (most.sigmas > kByChance) first.check.widen(most.sigmas, first.trajectory.problem);
      warnings.push_back("its motion or its lamps change in view: " +
                         measured_alone(first.trajectory.from_s, first.trajectory.to_s));
    }
  }
  Trajectory& seen = first.trajectory;
  if (track.kind == LampKind::taillamp && !site.lamps.classes_tell_tails() &&
      !(site.lamps.tail_height_m && site.lamps.tail_separation_m))
    warnings.push_back(
        std::string(
            "tail lamps: the site file has no lamps.tail_height_m or no tail_separation_m; ") +
        (site.lamps.height_m || site.lamps.separation_m
             ? "the headlamps' mean was taken with a std of at least 0.2 m"
             : "their lengths are unknown, as those of headlamps are"));
  seen.problem.sigma_factor = first.check.sigma_factor.cwiseMax(1.0);
  seen.problem.apart_factor = first.check.apart_factor;
  const auto level = [&](std::vector<Trajectory> found) -> Outcome<std::vector<Trajectory>> {
    const auto two_vehicles = of_two_vehicles(found.front(), first.check);
    if (!two_vehicles) return found;
    warnings.push_back(*two_vehicles);
    return Miss::ambiguous_identity;
  };
  if (first.scaled) {
    auto found = fit_hypotheses(seen, first.readings, site, track.direction);
    if (const Miss* miss = std::get_if<Miss>(&found)) return *miss;
    return level(std::get<std::vector<Trajectory>>(std::move(found)));
  }
  const auto again = fit_geometry(seen.problem, seen.fit.parameters);
  if (const Miss* miss = std::get_if<Miss>(&again)) return *miss;
  seen.fit = std::get<GeometryFit>(again);
  return level({std::move(seen)});
}

}  // namespace vildar
