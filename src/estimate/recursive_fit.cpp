#include "estimate/recursive_fit.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <ceres/jet.h>
#include <Eigen/LU>

#include "core/clock.h"
#include "estimate/geometry_cost.h"
#include "estimate/mixture.h"
#include "estimate/own_springs.h"
#include "estimate/weave.h"

namespace vildar {
namespace {

using PathJet = ceres::Jet<double, kPathParameters>;
using PathJets = std::array<PathJet, kPathParameters>;

PathJets jets_of(const PathVector& parameters) {
  PathJets jets;
  for (int i = 0; i < kPathParameters; ++i)
    jets[static_cast<std::size_t>(i)] = PathJet(parameters[i], i);
  return jets;
}

// Nearer than this the ratios to X that the unknowns are run away, and the reference stays.
constexpr double kNearest_m = 5.0;

// The unknowns for a reference `dt_s` later: X has shrunk to a share of itself.
PathJets moved(const PathJets& p, double dt_s) {
  const PathJet share = 1.0 - dt_s * (p[kClosingRate] + 0.5 * dt_s * p[kAcceleration]);
  PathJets later = p;
  later[kLogScale] += log(share);
  later[kClosingRate] = (p[kClosingRate] + dt_s * p[kAcceleration]) / share;
  later[kAcceleration] = p[kAcceleration] / share;
  later[kLateral] = p[kLateral] / share;
  later[kDrop] = p[kDrop] / share;
  later[kLogSeparation] -= log(share);
  later[kLogRadius] -= log(share);
  later[kStraight] = p[kStraight] / share;
  return later;
}

}  // namespace

struct RecursiveFit::Filter {
  Site site;
  Camera camera;
  Options options;
  VehicleTrack track;  // before the first estimate its sightings, after it the last one alone
  std::vector<Trajectory> trajectories;  // each thing that the vehicle may be
  Miss miss = Miss::too_short;
  double last_s = 0.0;
  double excess = 1.0;  // running mean of the squared whitened innovations

  Filter(const Site& given, const VehicleTrack& head, const Options& chosen)
      : site(given), camera(*given.camera), options(chosen), track(head) {
    track.sightings.clear();
  }

  void begin() {
    const double seen_s =
        seconds_of(track.sightings.back().time) - seconds_of(track.sightings.front().time);
    if (seen_s < options.first_s) return;
    std::vector<std::string> warnings;
    auto outcome = fit_trajectories(track, camera, site, warnings);
    if (const Miss* why = std::get_if<Miss>(&outcome)) {
      miss = *why;
      return;
    }
    trajectories = std::get<std::vector<Trajectory>>(std::move(outcome));
    if (std::ranges::any_of(trajectories,
                            [](const Trajectory& one) { return one.problem.setting.crosses(); })) {
      trajectories.clear();
      miss = Miss::bad_fit;
      return;
    }
    // The filter lets the acceleration wander by itself.
    for (Trajectory& trajectory : trajectories) {
      trajectory.problem.setting.steps.clear();
      trajectory.change = {};
    }
  }

  void predict(double time_s, Trajectory& trajectory) const {
    GeometryProblem& problem = trajectory.problem;
    GeometryFit& fit = trajectory.fit;
    const double dt_s = time_s - problem.reference_s;
    const double scale_m = std::exp(fit.parameters[kLogScale]);
    const double share =
        1.0 - dt_s * (fit.parameters[kClosingRate] + 0.5 * dt_s * fit.parameters[kAcceleration]);
    if (trajectory.ego.moving() || !(share * scale_m > kNearest_m)) return;
    const PathJets later = moved(jets_of(fit.parameters), dt_s);
    PathMatrix slopes;
    for (int i = 0; i < kPathParameters; ++i) {
      fit.parameters[i] = later[static_cast<std::size_t>(i)].a;
      slopes.row(i) = later[static_cast<std::size_t>(i)].v.transpose();
    }
    fit.covariance = slopes * fit.covariance * slopes.transpose();
    const double jerk = options.jerk_mps2_per_root_s / (share * scale_m);
    fit.covariance(kAcceleration, kAcceleration) += jerk * jerk * std::max(0.0, time_s - last_s);
    if (weave_counts(problem)) {
      const double weave = kWeave_m / (share * scale_m);
      fit.covariance(kLateral, kLateral) +=
          2.0 * weave * weave * std::max(0.0, time_s - last_s) / weaves_alike_s(problem.setting);
    }
    problem.reference_s = time_s;
  }

  // One lamp: both image axes at once, an outlier weighing as much as Huber's loss lets it.
  void update(std::size_t index, Trajectory& trajectory) {
    GeometryProblem& problem = trajectory.problem;
    GeometryFit& fit = trajectory.fit;
    const PathJets p = jets_of(fit.parameters);
    std::array<PathJet, 2> residual;
    if (!LampResidual{&problem, index}(p.data(), residual.data())) return;
    Eigen::Matrix<double, 2, kPathParameters> slopes;
    slopes.row(0) = residual[0].v.transpose();
    slopes.row(1) = residual[1].v.transpose();
    const Eigen::Vector2d error(residual[0].a, residual[1].a);
    constexpr double kMemory = 0.02;
    const double weight = std::min(1.0, kHuberBound / std::max(1e-9, error.norm()));
    excess += kMemory * (0.5 * weight * error.squaredNorm() - excess);
    const Eigen::Matrix<double, kPathParameters, 2> across = fit.covariance * slopes.transpose();
    const Eigen::Matrix2d innovation =
        slopes * across + Eigen::Matrix2d::Identity() * (std::max(1.0, excess) / weight);
    const Eigen::Matrix<double, kPathParameters, 2> gain = across * innovation.inverse();
    fit.parameters -= gain * error;
    fit.covariance -= gain * across.transpose();
    fit.covariance = (0.5 * (fit.covariance + fit.covariance.transpose())).eval();
  }

  void follow(const VehicleSighting& sighting) {
    const double time_s = seconds_of(sighting.time);
    const auto lamps =
        frame_lamps(sighting, 0, trajectories.front().bearing_of, camera, *site.camera);
    for (Trajectory& trajectory : trajectories) {
      GeometryProblem& problem = trajectory.problem;
      predict(time_s, trajectory);
      problem.lamps = lamps;
      problem.ego.clear();
      for (const LampObservation& lamp : lamps)
        problem.ego.push_back(trajectory.ego.deviation(problem.reference_s, lamp.time_s));
      // How far springs go stays as the first fit found it.
      for (std::size_t i = 0; i < lamps.size() && !problem.pairs; ++i) {
        double& sigma = problem.lamps[i].sigma.y();
        const double per_s = 1.0 / std::max(1e-3, time_s - last_s);
        sigma = std::hypot(sigma, springs_sigma_rad(problem.ego[i], per_s));
      }
      for (std::size_t i = 0; i < lamps.size(); ++i) update(i, trajectory);
      trajectory.frames += !lamps.empty();
    }
  }
};

RecursiveFit::RecursiveFit(const Site& site, const VehicleTrack& head, const Options& options) {
  if (!site.camera) throw std::invalid_argument("RecursiveFit: the site has no camera");
  filter_ = std::make_unique<Filter>(site, head, options);
}
RecursiveFit::~RecursiveFit() = default;
RecursiveFit::RecursiveFit(RecursiveFit&&) noexcept = default;
RecursiveFit& RecursiveFit::operator=(RecursiveFit&&) noexcept = default;

void RecursiveFit::add(const VehicleSighting& sighting) {
  if (!filter_->trajectories.empty()) {
    filter_->follow(sighting);
  } else {
    filter_->track.sightings.push_back(sighting);
    filter_->begin();
  }
  filter_->last_s = seconds_of(sighting.time);
}

std::optional<MotionState> RecursiveFit::state() const {
  if (filter_->trajectories.empty()) return std::nullopt;
  return mixed_state(filter_->trajectories, filter_->last_s);
}

Outcome<SpeedEstimate> RecursiveFit::speed() const {
  if (filter_->trajectories.empty()) return filter_->miss;
  return mixed_speed(filter_->trajectories, filter_->last_s);
}

}  // namespace vildar
