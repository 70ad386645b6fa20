#include "estimate/hypotheses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Cholesky>

#include "core/quantity.h"
#include "estimate/lane_choice.h"

namespace vildar {
namespace {

// Below this probability a hypothesis could not move a 95 % interval.
constexpr double kNegligible = 0.005;

double log_normal_peak(const Uncertain& prior) {
  return -std::log(prior.std * std::sqrt(2.0 * kPi));
}

// Beside a bend one who crosses goes another way for lamps of another class. Where the own vehicle
// speeds up or slows down, by metres that are told, another's steps make up for them by shares of
// its range.
bool steps_go_with_scale(const Trajectory& trajectory) {
  constexpr double kLeast_m = 0.3;
  const GeometryProblem& problem = trajectory.problem;
  if (problem.setting.steps.empty() || !problem.pairs || !problem.priors.separation_m) return false;
  if (trajectory.ego.moving())
    return !problem.setting.crosses() &&
           std::ranges::any_of(problem.ego, [](const EgoDeviation& own) {
             return std::abs(own.ahead_m) > kLeast_m;
           });
  return problem.setting.crosses() && problem.setting.bend != 0.0;
}

// ln of the integral of likelihood times priors, up to what all hypotheses have in common. The
// priors are densities of lengths, the unknowns ratios of these to X: each brings a factor X.
double log_evidence(const Trajectory& trajectory) {
  const GeometryProblem& problem = trajectory.problem;
  const MetricPriors& priors = problem.priors;
  double log_density = 0.0;
  int lengths = 2;  // acceleration; the lateral offset, with a lane or without
  if (priors.drop_m) {
    log_density += log_normal_peak(*priors.drop_m);
    ++lengths;
  }
  if (problem.pairs && priors.separation_m) {
    log_density += log_normal_peak(*priors.separation_m);
    ++lengths;
  }
  if (priors.straight_m) ++lengths;  // its density is the same for all
  if (priors.lateral_m) log_density += log_normal_peak(*priors.lateral_m);
  const std::vector<int> free = free_parameters(problem);
  const Eigen::MatrixXd covariance = trajectory.fit.covariance(free, free);
  const Eigen::VectorXd sigmas = covariance.diagonal().cwiseSqrt();
  const Eigen::MatrixXd correlation =
      sigmas.cwiseInverse().asDiagonal() * covariance * sigmas.cwiseInverse().asDiagonal();
  const double log_volume =
      sigmas.array().log().sum() + correlation.llt().matrixLLT().diagonal().array().log().sum();
  double cost = trajectory.fit.cost;
  if (problem.setting.crosses() || steps_go_with_scale(trajectory))
    cost += cost_of_steps(problem.setting, std::exp(trajectory.fit.parameters[kLogScale]));
  return log_density + lengths * trajectory.fit.parameters[kLogScale] + log_volume - cost;
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

// The same observations with other priors, from where the last fit stands.
Outcome<Trajectory> refit(Trajectory trajectory) {
  const auto outcome = fit_geometry(trajectory.problem, trajectory.fit.parameters);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) return *miss;
  trajectory.fit = std::get<GeometryFit>(outcome);
  return trajectory;
}

// Finds its steps for the priors it has, from the range at which its lamps would stand.
void step_anew(Trajectory& trajectory) {
  GeometryProblem& problem = trajectory.problem;
  if (!steps_go_with_scale(trajectory)) return;
  const Along along = problem.setting.crosses() ? Along::across : Along::road;
  PathVector path = trajectory.fit.parameters;
  const double longer =
      std::log(problem.priors.separation_m->mean) - path[kLogSeparation] - path[kLogScale];
  path[kLogScale] += longer;
  path[kLogRadius] -= longer;
  path[kStraight] *= std::exp(-longer);
  if (!fit_steps(problem, path, trajectory.frames, along)) return;
  trajectory.fit.parameters = path;
  if (auto change = find_motion_change(problem, trajectory.fit, trajectory.frames, along))
    trajectory.change = std::move(*change);
}

// The range of a lone lamp goes with one over what the pitch leaves of its elevation: where that is
// far from a line over what is known of the pitch, by parts of it. Their sum is its density to 4 %
// up to 2.5 sigmas.
std::vector<Trajectory> by_pitch(const Trajectory& whole) {
  struct Part {
    double mean, share;  // mean in standard deviations of the whole
  };
  constexpr std::array<Part, 5> kParts{
      {{-1.6, 0.0545}, {-0.8, 0.244}, {0.0, 0.403}, {0.8, 0.244}, {1.6, 0.0545}}};
  constexpr double kPartStd = 0.64, kCurved = 0.05;
  const Uncertain pitch_rad = whole.problem.priors.turn_rad[1];
  const double left_rad = std::sqrt(whole.fit.covariance(kPitch, kPitch));
  if (whole.problem.pairs || left_rad <= kCurved * std::abs(whole.fit.parameters[kDrop]))
    return {whole};
  std::vector<Trajectory> found;
  for (const Part& part : kParts) {
    Trajectory one = whole;
    one.problem.priors.turn_rad[1] = {pitch_rad.mean + part.mean * pitch_rad.std,
                                      kPartStd * pitch_rad.std};
    one.log_prior += std::log(part.share);
    const auto outcome = refit(std::move(one));
    if (const auto* fitted = std::get_if<Trajectory>(&outcome)) found.push_back(*fitted);
  }
  return found.empty() ? std::vector{whole} : found;
}

bool off_road(const RoadSite& road, Uncertain lateral_m, double ego_aside_std_m) {
  if (road.lanes.empty()) return false;
  const RoadEdges edges = road_edges(road);
  const double margin_m = 3.0 * std::hypot(lateral_m.std, ego_aside_std_m);
  return lateral_m.mean < edges.low_m - margin_m || lateral_m.mean > edges.high_m + margin_m;
}

std::size_t lanes_of(const RoadSite& road, Direction direction) {
  return static_cast<std::size_t>(
      std::count_if(road.lanes.begin(), road.lanes.end(),
                    [&](const LaneSite& lane) { return lane.direction == direction; }));
}

// One class of lamps, fitted without a lane, in each lane that it may be in.
void add_lanes(const Trajectory& anywhere, const LampReading& reading, const Site& site,
               Direction direction, std::vector<Trajectory>& found) {
  const std::size_t lanes = lanes_of(site.road, direction);
  const double crossed_m = anywhere.crossed_m();
  if (lanes == 0 || crossed_m > kAcrossALane_m) {
    found.push_back(anywhere);
    return;
  }
  const RoadEdges edges = road_edges(site.road);
  Trajectory no_lane = anywhere;
  no_lane.log_prior += std::log(kOffLaneShare / (edges.high_m - edges.low_m));
  found.push_back(std::move(no_lane));
  const double log_lane = std::log((1.0 - kOffLaneShare) / static_cast<double>(lanes));
  for (const LaneSite* lane : lanes_near(site.road, direction, lateral_of(anywhere))) {
    Trajectory inside = anywhere;
    inside.lane = lane->id;
    Uncertain lateral_m = lateral_from_camera_m(*lane, site, reading, inside.problem.pairs);
    lateral_m.std = std::hypot(lateral_m.std, inside.problem.ego_aside_std_m, crossed_m);
    inside.problem.priors.lateral_m = lateral_m;
    inside.log_prior += log_lane;
    const auto outcome = refit(std::move(inside));
    if (const auto* fitted = std::get_if<Trajectory>(&outcome)) found.push_back(*fitted);
  }
}

}  // namespace

void weigh(std::vector<Trajectory>& trajectories) {
  if (trajectories.size() == 1) {
    trajectories.front().weight = 1.0;
    return;
  }
  double most = -INFINITY;
  for (Trajectory& one : trajectories) {
    one.weight = one.log_prior + log_evidence(one);
    most = std::max(most, one.weight);
  }
  std::erase_if(trajectories, [](const Trajectory& one) { return !std::isfinite(one.weight); });
  const auto normalise = [&] {
    double sum = 0.0;
    for (const Trajectory& one : trajectories) sum += one.weight;
    for (Trajectory& one : trajectories) one.weight /= sum;
  };
  for (Trajectory& one : trajectories) one.weight = std::exp(one.weight - most);
  normalise();
  std::erase_if(trajectories, [](const Trajectory& one) { return one.weight < kNegligible; });
  normalise();
  std::stable_sort(trajectories.begin(), trajectories.end(),
                   [](const Trajectory& a, const Trajectory& b) { return a.weight > b.weight; });
}

Outcome<std::vector<Trajectory>> fit_hypotheses(const Trajectory& seen,
                                                const std::vector<LampReading>& readings,
                                                const Site& site, Direction direction) {
  // The chance of more, with up to seven priors, is one in a thousand; with nine three.
  constexpr double kMostPriorChi2 = 25.0;
  std::vector<Trajectory> found;
  std::optional<Miss> miss;
  for (const LampReading& reading : readings) {
    Trajectory anywhere = seen;
    anywhere.lamps = reading.id;
    anywhere.log_prior = std::log(reading.share);
    anywhere.problem.priors = metric_priors(site, reading);
    anywhere.problem.priors.acceleration_mps2 = seen.problem.priors.acceleration_mps2;
    step_anew(anywhere);
    auto outcome = refit(std::move(anywhere));
    if (const Miss* why = std::get_if<Miss>(&outcome)) {
      if (!miss) miss = *why;
      continue;
    }
    anywhere = std::get<Trajectory>(std::move(outcome));
    if (anywhere.fit.prior_chi2 > kMostPriorChi2 ||
        off_road(site.road, lateral_of(anywhere), anywhere.problem.ego_aside_std_m))
      miss = Miss::not_on_road;
    else
      for (const Trajectory& one : by_pitch(anywhere))
        add_lanes(one, reading, site, direction, found);
  }
  if (found.empty()) return *miss;
  weigh(found);
  if (found.empty()) return Miss::not_converged;
  return found;
}

}  // namespace vildar
