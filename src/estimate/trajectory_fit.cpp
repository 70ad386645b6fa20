#include <algorithm>
#include <cmath>
#include <optional>

#include "estimate/hypotheses.h"
#include "estimate/path_start.h"
#include "estimate/residual_check.h"
#include "estimate/trajectory.h"

namespace vildar {
namespace {

constexpr int kFewestFrames = 5;
constexpr double kShortest_s = 0.2;

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

std::optional<Miss> gate_residuals(const ResidualCheck& check) {
  constexpr double kWorstScatter_px = 5.0;
  constexpr double kMostOutliers = 0.3;
  if (check.scatter_px.maxCoeff() > kWorstScatter_px || check.outlier_share > kMostOutliers)
    return Miss::bad_fit;
  return std::nullopt;
}

}  // namespace

Outcome<std::vector<Trajectory>> fit_trajectories(const VehicleTrack& track, const Camera& camera,
                                                  const Site& site,
                                                  std::vector<std::string>& warnings) {
  const CameraView view = camera_view(track, camera, *site.camera);
  if (view.frames < kFewestFrames) return Miss::too_few_samples;
  const double from_s = view.lamps.front().time_s, to_s = view.lamps.back().time_s;
  if (to_s - from_s < kShortest_s) return Miss::too_short;

  Trajectory seen;
  seen.frames = view.frames;
  if (site.ego) seen.ego = EgoMotion(*site.ego);
  if (!seen.ego.covers(from_s, to_s))
    warnings.push_back("the ego speed trace does not span the whole track; its end speed is held");
  if (track.kind == LampKind::taillamp &&
      !(site.lamps.tail_height_m && site.lamps.tail_separation_m))
    warnings.push_back(
        "tail lamps: the site file has no lamps.tail_height_m or no tail_separation_m; the "
        "headlamps' mean was taken with a std of at least 0.2 m");
  const auto readings = lamp_readings(site.lamps, track.kind, view.pairs);
  GeometryProblem& problem = seen.problem;
  problem.setting = path_setting(*site.camera, site.road);
  problem.lamps = view.lamps;
  problem.pairs = view.pairs;
  problem.priors = metric_priors(site, likeliest(readings));

  const bool scaled = problem.priors.drop_m || (view.pairs && problem.priors.separation_m) ||
                      (problem.setting.bend != 0.0 && problem.priors.radius_m);
  if (!scaled) {
    const LaneSite* lane = only_lane(site.road, track.direction);
    if (!lane) return Miss::no_scale;
    problem.priors.lateral_m = lateral_from_camera_m(*lane, site, readings.front(), view.pairs);
    seen.lane = lane->id;
  }
  const auto first = fit_from_starts(problem, view, site.road, seen.ego);
  if (const Miss* miss = std::get_if<Miss>(&first)) return *miss;
  seen.fit = std::get<GeometryFit>(first);

  const ResidualCheck check = check_residuals(problem, seen.fit.parameters, camera.focal_px());
  if (const auto miss = gate_residuals(check)) return *miss;
  problem.sigma_factor = check.sigma_factor.cwiseMax(1.0);
  if (scaled) return fit_hypotheses(seen, readings, site, track.direction);
  const auto again = fit_geometry(problem, seen.fit.parameters);
  if (const Miss* miss = std::get_if<Miss>(&again)) return *miss;
  seen.fit = std::get<GeometryFit>(again);
  return std::vector{std::move(seen)};
}

}  // namespace vildar
