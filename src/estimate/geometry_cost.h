#pragma once

#include <span>
#include <utility>

#include <ceres/problem.h>

#include "estimate/geometry_fit.h"

namespace vildar {

// Residual functors shared by the camera-only fit and that of a site's passes; T may be a
// ceres::Jet.

/// Whitened error of one lamp in one frame.
struct LampResidual {
  const GeometryProblem* problem;
  std::size_t index;

  template <class T>
  bool operator()(const T* p, T* residual) const {
    const LampObservation& seen = problem->lamps[index];
    const double tau_s = seen.time_s - problem->reference_s;
    const Eigen::Matrix<T, 3, 1> ray =
        camera_axes(p, problem->setting,
                    lamp_from_camera_m(p, problem->setting, tau_s, seen.side, problem->ego[index]));
    if (!(ray.z() > T(1e-6))) return false;
    residual[0] =
        (ray.x() / ray.z() - seen.normalized.x()) / (seen.sigma.x() * problem->sigma_factor.x());
    // The nose up, all is seen lower.
    const T squat = p[kSquat] * problem->ego[index].springs_mps2;
    residual[1] = (ray.y() / ray.z() + squat - seen.normalized.y()) /
                  (seen.sigma.y() * problem->sigma_factor.y());
    return true;
  }

  /// Slopes by the lamp's place, per metre this way over the road.
  Eigen::Vector2d by_place(const double* p, double heading_rad) const {
    const LampObservation& seen = problem->lamps[index];
    const Eigen::Vector3d along = camera_axes<double>(
        p, problem->setting, {std::cos(heading_rad), std::sin(heading_rad), 0.0});
    const Eigen::Vector3d ray =
        camera_axes(p, problem->setting,
                    lamp_from_camera_m(p, problem->setting, seen.time_s - problem->reference_s,
                                       seen.side, problem->ego[index]));
    const Eigen::Array2d turned = (along.head<2>() - ray.head<2>() / ray.z() * along.z()) / ray.z();
    return turned / (seen.sigma.array() * problem->sigma_factor.array());
  }
};

/// Whitened error of how far apart two lamps of a frame are seen (apart_shares).
struct ApartResidual {
  const GeometryProblem* problem;
  std::size_t first;
  ApartShares shares;

  template <class T>
  bool operator()(const T* p, T* residual) const {
    T one[2], other[2];
    if (!LampResidual{problem, first}(p, one) || !LampResidual{problem, first + 1}(p, other))
      return false;
    *residual = shares.first * one[0] + shares.second * other[0];
    return true;
  }
};

/// All priors at once, in the order of MetricPriors, and those on the own motion.
struct PriorResidual {
  const GeometryProblem* problem;

  int count() const {
    const MetricPriors& priors = problem->priors;
    return has_drop() + has_separation() + priors.lateral_m.has_value() + has_radius() +
           priors.straight_m.has_value() + 1 + (priors.motion ? 2 : 0) + some_of(priors.turn_rad) +
           (priors.log_focal.std > 0.0) + some_of(problem->ego_unknowns);
  }

  /// Of these the first; those on the own motion come last.
  int metric_count() const { return count() - some_of(problem->ego_unknowns); }

  template <class T>
  bool operator()(const T* p, T* residual) const {
    using std::exp;
    const MetricPriors& priors = problem->priors;
    const T scale_m = exp(p[kLogScale]);
    const auto whiten = [](const T& value, const Uncertain& prior) {
      return (value - prior.mean) / prior.std;
    };
    if (has_drop()) *residual++ = whiten(scale_m * p[kDrop], *priors.drop_m);
    if (has_separation())
      *residual++ = whiten(scale_m * exp(p[kLogSeparation]), *priors.separation_m);
    if (priors.lateral_m) *residual++ = whiten(scale_m * p[kLateral], *priors.lateral_m);
    if (has_radius()) *residual++ = whiten(scale_m * exp(p[kLogRadius]), *priors.radius_m);
    if (priors.straight_m) *residual++ = whiten(scale_m * p[kStraight], *priors.straight_m);
    *residual++ = whiten(scale_m * p[kAcceleration], priors.acceleration_mps2);
    if (priors.motion) {
      // Whitened by the Cholesky factor of the covariance.
      const KnownMotion& motion = *priors.motion;
      const double tau_s = motion.time_s - problem->reference_s;
      const T speed = scale_m * (p[kClosingRate] + tau_s * p[kAcceleration] +
                                 problem->setting.departed_rate(tau_s)) -
                      motion.value[0];
      const T rate = scale_m * (p[kAcceleration] + problem->setting.departed_acceleration(tau_s)) -
                     motion.value[1];
      const double l00 = std::sqrt(motion.covariance(0, 0));
      const double l10 = motion.covariance(1, 0) / l00;
      const double l11 = std::sqrt(motion.covariance(1, 1) - l10 * l10);
      const T first = speed / l00;
      *residual++ = first;
      *residual++ = (rate - l10 * first) / l11;
    }
    using Unknowns = std::span<const Uncertain>;
    for (const auto& [unknowns, first] : {std::pair(Unknowns(priors.turn_rad), kYaw),
                                          std::pair(Unknowns(&priors.log_focal, 1), kLogFocal),
                                          std::pair(Unknowns(problem->ego_unknowns), kHeading)})
      for (std::size_t i = 0; i < unknowns.size(); ++i)
        if (unknowns[i].std > 0.0)
          *residual++ = whiten(p[first + static_cast<int>(i)], unknowns[i]);
    return true;
  }

 private:
  bool has_drop() const { return problem->priors.drop_m.has_value(); }
  bool has_separation() const { return problem->pairs && problem->priors.separation_m; }
  bool has_radius() const {
    return problem->setting.bend != 0.0 && problem->priors.radius_m.has_value();
  }
  static int some_of(std::span<const Uncertain> unknowns) {
    int count = 0;
    for (const Uncertain& one : unknowns) count += one.std > 0.0;
    return count;
  }
};

/// Residuals of two axes of one lamp share a loss: this bound on their norm keeps 95 % efficiency.
inline constexpr double kHuberBound = 1.345 * 1.4142135623730951;
/// And of one residual.
inline constexpr double kApartBound = 1.345;

/// Adds all residuals of `problem` on the parameter block `path`, of which only `free` may move.
/// Problem and losses (those of bounds kHuberBound and kApartBound) outlive `ceres_problem`, which
/// must not own them.
void add_geometry(const GeometryProblem& problem, double* path, const std::vector<int>& free,
                  ceres::LossFunction* loss, ceres::LossFunction* apart_loss,
                  ceres::Problem& ceres_problem);

}  // namespace vildar
