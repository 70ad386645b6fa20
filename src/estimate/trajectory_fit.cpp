#include <algorithm>
#include <cmath>
#include <optional>

#include "estimate/lane_choice.h"
#include "estimate/path_start.h"
#include "estimate/residual_check.h"
#include "estimate/trajectory.h"

namespace vildar {
namespace {

constexpr int kFewestFrames = 5;
constexpr double kShortest_s = 0.2;
// Spread of tail lamps about what the site file says of headlamps: UN R48 lets rear position lamps
// stand from 0.35 to 1.5 m high.
constexpr double kTailLampSpread_m = 0.2;
// A quantity that the site file calls known is taken as good to this.
constexpr double kKnown_m = 0.001;
// A lane's true curvature and the path driven in it differ by this share of the radius at least.
constexpr double kKnownRadius = 0.005;

Uncertain with_floor(Uncertain value, double floor_m = kKnown_m) {
  return {value.mean, std::max(value.std, floor_m)};
}

// What the site says of the lamps that this track shows.
std::optional<Uncertain> lamp_prior_m(const std::optional<Uncertain>& head_m,
                                      const std::optional<Uncertain>& tail_m, LampKind kind) {
  if (kind != LampKind::taillamp) return head_m;
  if (tail_m || !head_m) return tail_m;
  return Uncertain{head_m->mean, std::max(head_m->std, kTailLampSpread_m)};
}

MetricPriors priors_of(const Site& site, const VehicleTrack& track) {
  const CameraSite& camera = *site.camera;
  MetricPriors priors;
  const LampsSite& lamps = site.lamps;
  if (const auto height_m = lamp_prior_m(lamps.height_m, lamps.tail_height_m, track.kind))
    priors.drop_m = with_floor({camera.position_m[2].mean - height_m->mean,
                                std::hypot(height_m->std, camera.position_m[2].std)});
  if (const auto separation_m =
          lamp_prior_m(lamps.separation_m, lamps.tail_separation_m, track.kind))
    priors.separation_m = with_floor(*separation_m);
  if (site.road.radius_m)
    priors.radius_m = with_floor(*site.road.radius_m, kKnownRadius * site.road.radius_m->mean);
  priors.turn_rad = {Uncertain{0.0, camera.yaw_rad.std}, Uncertain{0.0, camera.pitch_rad.std},
                     Uncertain{0.0, camera.roll_rad.std}};
  return priors;
}

Uncertain lateral_from_camera_m(const LaneSite& lane, const Site& site, bool pairs) {
  const Uncertain prior_m = lane_prior_m(lane);
  const Uncertain& camera_m = site.camera->position_m[1];
  // One lamp stands for its vehicle: it may be either of a pair, or ride anywhere in the lane.
  const double half_pair_m =
      pairs ? 0.0 : 0.5 * (site.lamps.separation_m ? site.lamps.separation_m->mean : 1.25);
  return {prior_m.mean - camera_m.mean,
          std::hypot(std::hypot(prior_m.std, camera_m.std), half_pair_m)};
}

const LaneSite* only_lane(const RoadSite& road, Direction direction) {
  const LaneSite* found = nullptr;
  for (const LaneSite& lane : road.lanes) {
    if (lane.direction != direction) continue;
    if (found) return nullptr;
    found = &lane;
  }
  return found;
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

// Best of the fits from all starts, tried in the order of their costs; the first that explains the
// data is taken without trying the others.
Outcome<GeometryFit> fit_from_starts(GeometryProblem& problem, const CameraView& view,
                                     const RoadSite& road, const EgoMotion& ego) {
  const NominalSizes sizes = nominal_sizes(problem);
  const auto paths = rough_paths(view, problem.setting, sizes);
  if (paths.empty()) return Miss::not_on_road;
  problem.reference_s = reference_time_s(paths.front());
  problem.ego.clear();
  for (const LampObservation& lamp : problem.lamps)
    problem.ego.push_back(ego.deviation(problem.reference_s, lamp.time_s));
  std::vector<std::pair<double, PathVector>> starts;
  for (const RoughPath& path : paths) {
    const auto start = start_of(path, problem.setting, road, ego, problem.reference_s, sizes);
    const auto cost = start ? geometry_cost(problem, *start) : std::nullopt;
    if (cost) starts.emplace_back(*cost, *start);
  }
  if (starts.empty()) return Miss::not_on_road;
  std::sort(starts.begin(), starts.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  const double explained = 4.0 * static_cast<double>(problem.lamps.size());
  Outcome<GeometryFit> best = Miss::not_converged;
  for (const auto& [cost, start] : starts) {
    const auto outcome = fit_geometry(problem, start);
    const GeometryFit* fit = std::get_if<GeometryFit>(&outcome);
    const GeometryFit* known = std::get_if<GeometryFit>(&best);
    if (!known || (fit && fit->cost < known->cost)) best = outcome;
    if (fit && fit->cost < explained) break;
  }
  return best;
}

Uncertain lateral_of(const Trajectory& trajectory) {
  const PathMatrix& covariance = trajectory.fit.covariance;
  const double scale_m = std::exp(trajectory.fit.parameters[kLogScale]);
  const double ratio = trajectory.fit.parameters[kLateral];
  const double variance =
      covariance(kLateral, kLateral) +
      ratio * (2.0 * covariance(kLogScale, kLateral) + ratio * covariance(kLogScale, kLogScale));
  return {trajectory.lateral_m(), scale_m * std::sqrt(std::max(0.0, variance))};
}

Outcome<Trajectory> refit(Trajectory trajectory) {
  const auto outcome = fit_geometry(trajectory.problem, trajectory.fit.parameters);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) return *miss;
  trajectory.fit = std::get<GeometryFit>(outcome);
  return trajectory;
}

std::optional<Miss> gate_residuals(const ResidualCheck& check) {
  constexpr double kWorstScatter_px = 5.0;
  constexpr double kMostOutliers = 0.3;
  if (check.scatter_px.maxCoeff() > kWorstScatter_px || check.outlier_share > kMostOutliers)
    return Miss::bad_fit;
  return std::nullopt;
}

}  // namespace

Outcome<Trajectory> fit_trajectory(const VehicleTrack& track, const Camera& camera,
                                   const Site& site, std::vector<std::string>& warnings) {
  const CameraView view = camera_view(track, camera, *site.camera);
  if (view.frames < kFewestFrames) return Miss::too_few_samples;
  const double from_s = view.lamps.front().time_s, to_s = view.lamps.back().time_s;
  if (to_s - from_s < kShortest_s) return Miss::too_short;

  Trajectory trajectory;
  trajectory.frames = view.frames;
  if (site.ego) trajectory.ego = EgoMotion(*site.ego);
  if (!trajectory.ego.covers(from_s, to_s))
    warnings.push_back("the ego speed trace does not span the whole track; its end speed is held");
  if (track.kind == LampKind::taillamp &&
      !(site.lamps.tail_height_m && site.lamps.tail_separation_m))
    warnings.push_back(
        "tail lamps: the site file has no lamps.tail_height_m or no tail_separation_m; the "
        "headlamps' "
        "mean was taken with a std of at least 0.2 m");
  GeometryProblem& problem = trajectory.problem;
  problem.setting = path_setting(*site.camera, site.road);
  problem.lamps = view.lamps;
  problem.pairs = view.pairs;
  problem.priors = priors_of(site, track);

  const bool scaled = problem.priors.drop_m || (view.pairs && problem.priors.separation_m) ||
                      (problem.setting.bend != 0.0 && problem.priors.radius_m);
  if (!scaled) {
    const LaneSite* lane = only_lane(site.road, track.direction);
    if (!lane) return Miss::no_scale;
    problem.priors.lateral_m = lateral_from_camera_m(*lane, site, view.pairs);
    trajectory.lane = lane->id;
    trajectory.lane_used = true;
  }
  const auto first = fit_from_starts(problem, view, site.road, trajectory.ego);
  if (const Miss* miss = std::get_if<Miss>(&first)) return *miss;
  trajectory.fit = std::get<GeometryFit>(first);

  const ResidualCheck check =
      check_residuals(problem, trajectory.fit.parameters, camera.focal_px());
  if (const auto miss = gate_residuals(check)) return *miss;
  if ((check.sigma_factor.array() > 1.0).any()) {
    problem.sigma_factor = check.sigma_factor;
    const auto outcome = refit(trajectory);
    if (const Miss* miss = std::get_if<Miss>(&outcome)) return *miss;
    trajectory = std::get<Trajectory>(outcome);
  }
  // The chance of more, with up to seven priors, is one in a thousand.
  constexpr double kMostPriorChi2 = 25.0;
  if (trajectory.fit.prior_chi2 > kMostPriorChi2) return Miss::not_on_road;

  const LaneChoice choice = choose_lane(site.road, track.direction, lateral_of(trajectory));
  if (choice.off_road) return Miss::not_on_road;
  if (choice.lane && !trajectory.lane_used) {
    problem.priors.lateral_m = lateral_from_camera_m(*choice.lane, site, view.pairs);
    trajectory.lane = choice.lane->id;
    trajectory.lane_used = true;
    return refit(std::move(trajectory));
  }
  return trajectory;
}

}  // namespace vildar
