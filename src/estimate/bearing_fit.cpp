#include "estimate/bearing_fit.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "core/clock.h"
#include "core/median.h"
#include "estimate/camera_view.h"
#include "estimate/lane_choice.h"
#include "estimate/own_springs.h"
#include "estimate/path_start.h"
#include "estimate/speed_gate.h"
#include "estimate/weave.h"

namespace vildar {
namespace {

constexpr int kFewestFrames = 5;
constexpr double kShortest_s = 0.2;
constexpr double kFarOff = 1.5;  // sigmas that are wrong by so much lead a fit astray

const LaneSite* only_lane(const RoadSite& road, Direction direction) {
  const LaneSite* found = nullptr;
  for (const LaneSite& lane : road.lanes) {
    if (lane.direction != direction) continue;
    if (found) return nullptr;
    found = &lane;
  }
  return found;
}

const LampReading& likeliest(const std::vector<LampReading>& readings) {
  return *std::max_element(
      readings.begin(), readings.end(),
      [](const LampReading& a, const LampReading& b) { return a.share < b.share; });
}

NominalSizes nominal_sizes(const GeometryProblem& problem) {
  const MetricPriors& priors = problem.priors;
  NominalSizes sizes;
  sizes.drop_m = priors.drop_m ? priors.drop_m->mean : problem.setting.camera_m.z() - 0.7;
  if (priors.separation_m) sizes.separation_m = priors.separation_m->mean;
  if (priors.lateral_m) sizes.lateral_m = priors.lateral_m->mean;
  if (priors.radius_m) sizes.radius_m = priors.radius_m->mean;
  return sizes;
}

double usual_range_m(const std::vector<RoughPath>& paths) {
  std::vector<double> by_path_m;
  for (const RoughPath& path : paths) {
    std::vector<double> range_m;
    for (const RoughPoint& point : path) range_m.push_back(point.place_m.norm());
    by_path_m.push_back(median(std::move(range_m)));
  }
  return median(std::move(by_path_m));
}

// How far springs go is an unknown of the fit. How they follow the acceleration shows in what is
// left over where the lamps' separation tells the range as well; one lamp's way takes it for its
// own.
void let_springs_work(GeometryProblem& problem) {
  if (!springs_work(problem.ego)) return;
  problem.ego_unknowns[kSquat - kHeading] = kUsualSquat;
  if (problem.pairs) return;
  constexpr double kShort_s = 1.0;
  const auto [first, last] = std::ranges::minmax(problem.lamps, {}, &LampObservation::time_s);
  const double per_s =
      static_cast<double>(problem.lamps.size()) / std::max(last.time_s - first.time_s, kShort_s);
  for (std::size_t i = 0; i < problem.lamps.size(); ++i) {
    double& sigma = problem.lamps[i].sigma.y();
    sigma = std::hypot(sigma, springs_sigma_rad(problem.ego[i], per_s));
  }
}

// What is unknown of the own vehicle's turns, left out: where nothing tells them they and another's
// lane change look alike.
void drive_straight(GeometryProblem& problem, const EgoMotion& ego) {
  if (ego.knows_turns()) return;
  std::fill(problem.ego_unknowns.end() - kOwnSwings, problem.ego_unknowns.end(), Uncertain{});
}

// A pair that goes from lane to lane, by one that drives straight. A fit in one lane would go far
// astray: it takes the way across for one along the road.
Outcome<GeometryFit> fit_crossing(GeometryProblem problem, const EgoMotion& ego, int frames,
                                  const PathVector& start, std::vector<AccelerationStep>& steps) {
  drive_straight(problem, ego);
  problem.setting.steps.clear();
  PathVector path = start;
  fit_steps(problem, path, frames, Along::across);
  steps = problem.setting.steps;
  return fit_geometry(problem, path);
}

// Best of the fits from all starts, tried in the order of their costs; the first that explains the
// data is taken without trying the others.
Outcome<GeometryFit> fit_from_starts(GeometryProblem& problem, const CameraView& view,
                                     const RoadSite& road, const EgoMotion& ego, Along wanders,
                                     Weave weave) {
  const NominalSizes sizes = nominal_sizes(problem);
  auto paths = rough_paths(view, problem.setting, sizes);
  // From low down one lamp may be seen above where the horizon is told to be.
  const bool above_horizon = paths.empty();
  for (const LaneSite& lane : road.lanes) {
    if (!above_horizon) break;
    NominalSizes in_lane = sizes;
    in_lane.lateral_m = lane.lateral_m.mean - problem.setting.camera_m.y();
    std::ranges::move(rough_paths(view, problem.setting, in_lane), std::back_inserter(paths));
  }
  if (paths.empty()) return Miss::not_on_road;
  problem.reference_s = reference_time_s(paths.front());
  problem.setting.own_mps = ego.speed_mps(problem.reference_s);
  const OwnWay own = ego.own_way(problem.reference_s, usual_range_m(paths));
  problem.ego_unknowns = {own.heading_rad, own.delay_s};
  std::ranges::copy(own.swings, problem.ego_unknowns.end() - kOwnSwings);
  problem.ego_aside_std_m = own.aside_std_m;
  if (auto& lateral_m = problem.priors.lateral_m)
    lateral_m->std = std::hypot(lateral_m->std, own.aside_std_m);
  problem.ego.clear();
  for (const LampObservation& lamp : problem.lamps)
    problem.ego.push_back(ego.deviation(problem.reference_s, lamp.time_s));
  let_springs_work(problem);
  problem.setting.ego_unsure =
      std::ranges::any_of(problem.ego_unknowns, [](const Uncertain& one) { return one.std > 0.0; });
  const bool weaves =
      !ego.moving() && wanders == Along::road && (weave == Weave::allowed || weave_counts(problem));
  if (weaves) let_weave(problem, usual_range_m(paths));
  std::vector<std::pair<double, PathVector>> starts;
  for (const RoughPath& path : paths)
    for (const Look look : {Look::as_told, Look::by_path}) {
      const auto start = start_of(path, problem, road, ego, sizes, look);
      const auto cost = start ? geometry_cost(problem, *start) : std::nullopt;
      if (cost) starts.emplace_back(*cost, *start);
    }
  if (starts.empty()) return Miss::not_on_road;
  std::sort(starts.begin(), starts.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  constexpr double kSameRange = 0.05;  // relative
  const double explained = 4.0 * static_cast<double>(problem.lamps.size());
  Outcome<GeometryFit> best = Miss::not_converged;
  double best_start = 0.0;
  for (const auto& [cost, start] : starts) {
    std::vector<AccelerationStep> steps;
    if (weaves) let_weave(problem, std::exp(start[kLogScale]));
    const auto outcome = wanders == Along::across
                             ? fit_crossing(problem, ego, view.frames, start, steps)
                             : fit_geometry(problem, start);
    const GeometryFit* fit = std::get_if<GeometryFit>(&outcome);
    const GeometryFit* known = std::get_if<GeometryFit>(&best);
    if (!known || (fit && fit->cost < known->cost)) {
      best = outcome;
      best_start = start[kLogScale];
      problem.setting.steps = std::move(steps);
    }
    if (fit && fit->cost < explained) break;
  }
  const GeometryFit* fit = std::get_if<GeometryFit>(&best);
  if (!weaves || !fit) return best;
  const double scale = fit->parameters[kLogScale];
  let_weave(problem, std::exp(scale));
  if (std::abs(scale - best_start) < kSameRange) return best;
  const auto again = fit_geometry(problem, fit->parameters);
  return std::holds_alternative<GeometryFit>(again) ? again : best;
}

struct Bearings {
  std::vector<LampObservation> lamps;
  std::vector<EgoDeviation> ego;
};

// The loss tames a light that was taken for the lamp, but of a row of them each still pulls. Of all
// that was seen one in 3000 is left out by chance; where many would be, it is the model that is
// wrong, and none is.
void leave_out_strays(GeometryProblem& problem, const PathVector& parameters, const Bearings& all) {
  constexpr double kStray = 4.0;  // sigmas, of both axes together
  constexpr double kMostShare = 0.3;
  problem.lamps = all.lamps;
  problem.ego = all.ego;
  Eigen::Matrix2Xd off = bearing_residuals(problem, parameters);
  for (int axis = 0; axis < 2; ++axis) {
    const auto row = off.row(axis);
    off.row(axis) /= std::max(problem.sigma_factor[axis], robust_sigma({row.begin(), row.end()}));
  }
  Bearings kept;
  for (std::size_t i = 0; i < all.lamps.size(); ++i) {
    if (off.col(static_cast<Eigen::Index>(i)).norm() > kStray) continue;
    kept.lamps.push_back(all.lamps[i]);
    kept.ego.push_back(all.ego[i]);
  }
  const auto most = static_cast<double>(all.lamps.size());
  if (static_cast<double>(kept.lamps.size()) < (1.0 - kMostShare) * most) return;
  problem.lamps = std::move(kept.lamps);
  problem.ego = std::move(kept.ego);
}

}  // namespace

bool BearingFit::explains() const {
  constexpr double kMostOutliers = 0.3;
  constexpr double kNearest_m = 1.0;  // no vehicle drives through the camera
  const MotionState state = trajectory.at(trajectory.problem.reference_s);
  const Eigen::Vector2d from_camera_m = Eigen::Vector2d(state.range_m, state.lateral_m) -
                                        trajectory.problem.setting.camera_m.head<2>();
  return (check.scatter_px.array() <= most_scatter_px.array()).all() &&
         check.outlier_share <= kMostOutliers && from_camera_m.norm() > kNearest_m &&
         std::abs(state.acceleration_mps2) <= kHardestBraking_mps2;
}

bool BearingFit::told_apart() const {
  constexpr double kTold = 2.0, kBetter = 0.5;
  return check.apart_factor < kTold && check.apart_factor < kBetter * check.sigma_factor.x();
}

bool BearingFit::leaves_lane() const {
  constexpr double kMostWeave = 16.0;  // chi-square of six curves: one in seventy by chance
  const GeometryProblem& problem = trajectory.problem;
  if (!problem.setting.weaves || problem.setting.bend == 0.0) return false;
  double chi2 = 0.0;
  for (int i = kOwnSwing; i < kPathParameters; ++i) {
    const Uncertain& prior = problem.ego_unknowns[static_cast<std::size_t>(i - kHeading)];
    if (prior.std > 0.0) chi2 += std::pow(trajectory.fit.parameters[i] / prior.std, 2);
  }
  return chi2 > kMostWeave;
}

bool BearingFit::steady() const {
  constexpr double kMostMisfit = 3.5;  // one track in two hundred by chance
  return explains() && check.misfit <= kMostMisfit;
}

namespace {

std::vector<LampReading> readings_of(const VehicleTrack& track, const Site& site) {
  return lamp_readings(site.lamps, track.kind, !track.single_lamp);
}

Outcome<BearingFit> fit_way(const VehicleTrack& track, const Camera& camera, const Site& site,
                            const LampReading& reading, Along wanders, Weave weave) {
  const CameraView view = camera_view(track, camera, *site.camera);
  if (view.frames < kFewestFrames) return Miss::too_few_samples;
  if (view.lamps.back().time_s - view.lamps.front().time_s < kShortest_s) return Miss::too_short;

  BearingFit found;
  found.readings = readings_of(track, site);
  Trajectory& seen = found.trajectory;
  constexpr double kMostScatter_px = 5.0, kMostPitch_rad = 0.015;
  found.most_scatter_px = {
      kMostScatter_px,
      site.ego ? std::max(kMostScatter_px, kMostPitch_rad * camera.focal_px()) : kMostScatter_px};
  seen.frames = view.frames;
  seen.bearing_of = view.of;
  seen.from_s = seconds_of(track.sightings.front().time);
  seen.to_s = seconds_of(track.sightings.back().time);
  if (site.ego)
    seen.ego = EgoMotion(*site.ego, site.road,
                         Watched{{seen.from_s, seen.to_s}, track.direction == Direction::receding});
  GeometryProblem& problem = seen.problem;
  problem.setting = path_setting(*site.camera, site.road);
  problem.lamps = view.lamps;
  problem.pairs = view.pairs();
  problem.priors = metric_priors(site, reading);
  found.scaled = problem.priors.drop_m || (view.pairs() && problem.priors.separation_m) ||
                 (problem.setting.bend != 0.0 && problem.priors.radius_m);
  if (!found.scaled) {
    const LaneSite* lane = only_lane(site.road, track.direction);
    if (!lane) return Miss::no_scale;
    problem.priors.lateral_m =
        lateral_from_camera_m(*lane, site, found.readings.front(), view.pairs());
    seen.lane = lane->id;
  }
  const auto outcome = fit_from_starts(problem, view, site.road, seen.ego, wanders, weave);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) return *miss;
  seen.fit = std::get<GeometryFit>(outcome);
  // All that was seen judges the fit, also what it leaves out.
  const Bearings all{problem.lamps, problem.ego};
  const auto look = [&] {
    GeometryProblem judged = problem;
    judged.lamps = all.lamps;
    judged.ego = all.ego;
    found.check = check_residuals(judged, seen.fit.parameters, camera.focal_px());
  };
  const auto fit_again = [&] {
    const auto again = fit_geometry(problem, seen.fit.parameters);
    if (const auto* fit = std::get_if<GeometryFit>(&again)) seen.fit = *fit;
  };
  const auto let_wander = [&](const Eigen::Vector2d& sigma_factor, double apart_factor) {
    problem.sigma_factor = sigma_factor;
    problem.apart_factor = apart_factor;
    if (auto change = find_motion_change(problem, seen.fit, seen.frames, wanders))
      seen.change = std::move(*change);
  };
  const auto shakes = [&] {
    constexpr double kShakes = 4.0;
    return (found.check.sigma_factor.array() > kShakes * found.check.quick_factor.array()).any();
  };
  Eigen::Vector2d in_one_motion;  // what a fit of constant acceleration asks for
  // Where the camera shakes slowly both lamps move together, and a way that follows where they are
  // seen follows the shake. How far apart they are seen tells the motion then, and by that motion
  // what the shake is; within bounds, for the less the places count, the further from them do the
  // priors draw the pose.
  const auto follow_apart = [&] {
    constexpr int kFollowed = 4;
    constexpr double kContradicts = 2.0, kFarLess = 0.5, kMostGrowth = 2.0, kSettledFactor = 1.2;
    ResidualCheck& check = found.check;
    if (!shakes() || check.apart_factor < kContradicts || !std::isfinite(check.apart_factor))
      return;
    const BearingFit before = found;
    const Eigen::Vector2d most = kMostGrowth * in_one_motion.cwiseMax(check.sigma_factor);
    for (int round = 0; round < kFollowed; ++round) {
      problem.sigma_factor = check.sigma_factor;
      problem.apart_factor = round == 0 ? check.quick_apart_factor : check.apart_factor;
      if (!fit_steps(problem, seen.fit.parameters, seen.frames, Along::road)) break;
      look();
      check.sigma_factor = check.sigma_factor.cwiseMin(most);
      const auto settled = [&](double now, double told) {
        return std::max(now / told, told / now) < kSettledFactor;
      };
      if (settled(check.apart_factor, problem.apart_factor) &&
          settled(check.sigma_factor.x(), problem.sigma_factor.x()) &&
          settled(check.sigma_factor.y(), problem.sigma_factor.y()))
        break;
    }
    if (!found.explains() || check.apart_factor > kFarLess * before.check.apart_factor)
      found = before;
  };
  look();
  in_one_motion = found.check.sigma_factor;
  const Eigen::Vector2d quick = found.check.quick_factor;
  const double quick_apart = found.check.quick_apart_factor;
  if ((quick.array() > kFarOff).any()) {
    problem.sigma_factor = quick;
    problem.apart_factor = quick_apart;
    fit_again();
  }
  // Beside the scatter from frame to frame, what is left may be the vehicle's motion, and what that
  // leaves far off no lamp of it.
  constexpr int kRounds = 2, kMostSettling = 24;
  constexpr double kSettled = 1e-4;  // relative, of the range
  // Of the own turns beside a lane change the first fit knows nothing.
  for (int round = 0; wanders == Along::across && round < kMostSettling; ++round) {
    const double before = seen.fit.parameters[kLogScale];
    let_wander(quick, quick_apart);
    fit_again();
    if (std::abs(seen.fit.parameters[kLogScale] - before) < kSettled) break;
  }
  for (int round = 0; round < kRounds; ++round) {
    let_wander(quick, quick_apart);
    leave_out_strays(problem, seen.fit.parameters, all);
  }
  if (problem.lamps.size() < all.lamps.size()) {
    fit_again();
    let_wander(quick, quick_apart);
  }
  look();
  // Of others the way is told by where they are seen.
  if (site.ego && track.direction == Direction::receding && wanders == Along::road &&
      problem.pairs) {
    follow_apart();
    if (found.told_apart()) found.check.misfit = found.check.apart_misfit;
  }
  // What even that leaves makes its size less sure. The bearings are no longer judged by it: where
  // little else holds the pose, priors now draw the path away from them.
  if ((found.check.sigma_factor.array() > kFarOff * quick.array()).any() ||
      found.check.apart_factor > kFarOff * quick_apart)
    let_wander(found.check.sigma_factor, found.check.apart_factor);
  return found;
}

Outcome<BearingFit> crossing(const VehicleTrack& track, const Camera& camera, const Site& site,
                             const LampReading& reading) {
  const double kMost_m = site.ego ? 10.0 : 5.0, kMost_mps = site.ego ? 5.0 : 3.0;
  constexpr int kLooks = 20;
  auto outcome = fit_way(track, camera, site, reading, Along::across, Weave::where_told);
  const BearingFit* found = std::get_if<BearingFit>(&outcome);
  if (!found) return outcome;
  const Trajectory& seen = found->trajectory;
  const PathSetting& setting = seen.problem.setting;
  const double scale_m = std::exp(seen.fit.parameters[kLogScale]);
  for (int i = 0; i <= kLooks; ++i) {
    const double tau_s =
        seen.from_s + (seen.to_s - seen.from_s) * i / kLooks - seen.problem.reference_s;
    if (std::abs(scale_m * setting.departed_rate(tau_s, Along::across)) > kMost_mps)
      return Miss::bad_fit;
  }
  const double crossed_m = seen.crossed_m();
  if ((setting.bend == 0.0 && crossed_m < kAcrossALane_m) || crossed_m > kMost_m)
    return Miss::bad_fit;
  return outcome;
}

}  // namespace

Outcome<BearingFit> fit_bearings(const VehicleTrack& track, const Camera& camera, const Site& site,
                                 Weave weave) {
  return fit_way(track, camera, site, likeliest(readings_of(track, site)), Along::road, weave);
}

Outcome<BearingFit> fit_lane_change(const VehicleTrack& track, const Camera& camera,
                                    const Site& site) {
  const std::vector<LampReading> readings = readings_of(track, site);
  if (site.ego || site.road.kind == RoadKind::straight)
    return crossing(track, camera, site, likeliest(readings));
  // Beside a bend lengths of another class make it another way.
  Outcome<BearingFit> best = Miss::bad_fit;
  double least = INFINITY;
  for (const LampReading& reading : readings) {
    auto outcome = crossing(track, camera, site, reading);
    const BearingFit* fit = std::get_if<BearingFit>(&outcome);
    if (!fit) continue;
    const Trajectory& seen = fit->trajectory;
    const double cost =
        seen.fit.cost - std::log(reading.share) +
        cost_of_steps(seen.problem.setting, std::exp(seen.fit.parameters[kLogScale]));
    if (cost >= least) continue;
    least = cost;
    best = std::move(outcome);
  }
  return best;
}

}  // namespace vildar
