#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "core/outcome.h"
#include "estimate/camera_view.h"
#include "estimate/path_model.h"
#include "estimate/solve.h"

namespace vildar {

/// Speed toward the sensor and its rate of change at one time, known from elsewhere than the
/// bearings.
struct KnownMotion {
  double time_s = 0.0;
  Eigen::Vector2d value = Eigen::Vector2d::Zero();  ///< m/s, m/s^2
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();
};

/// Half the distance between the lamps of a pair where nothing is told of it.
inline constexpr double kHalfPair_m = 0.62;

/// What is known in metres. Each is a normal prior; an absent one says nothing.
struct MetricPriors {
  std::optional<Uncertain> drop_m;        ///< camera height less lamp height
  std::optional<Uncertain> separation_m;  ///< between the lamps of a pair
  std::optional<Uncertain> lateral_m;     ///< lateral offset from the camera
  std::optional<Uncertain> radius_m;      ///< of the road's line y = 0
  std::optional<Uncertain> straight_m;    ///< x of the bend's begin; absent: exactly known
  Uncertain acceleration_mps2{0.0, 1.5};
  std::optional<KnownMotion> motion;
  std::array<Uncertain, 3> turn_rad{};  ///< yaw, pitch, roll from the mean pose; std 0: fixed
  Uncertain log_focal;                  ///< std 0: fixed
};

struct GeometryProblem {
  PathSetting setting;
  std::vector<LampObservation> lamps;
  std::vector<EgoDeviation> ego;  ///< one per observation
  /// p[kHeading..]; std 0: fixed
  std::array<Uncertain, kPathParameters - kHeading> ego_unknowns{};
  double ego_aside_std_m = 0.0;  ///< of every lane, as seen from the camera's own vehicle
  double reference_s = 0.0;
  bool pairs = false;
  MetricPriors priors;
  /// Factors on the observations' sigmas, image u and v: what the residuals ask for.
  Eigen::Vector2d sigma_factor = Eigen::Vector2d::Ones();
  /// Factor on the sigma of how far apart the two lamps of a frame are seen, image u: below
  /// sigma_factor where they shake together.
  double apart_factor = std::numeric_limits<double>::infinity();
};

/// What two lamps of a frame say of how far apart they are beyond what each says of itself: shares
/// of their whitened residuals, image u, the sum of which is a whitened residual of its own.
struct ApartShares {
  double first = 0.0, second = 0.0;
};
/// Of lamps `first` and the next; nothing where these are no pair of one frame, or say no more.
std::optional<ApartShares> apart_shares(const GeometryProblem& problem, std::size_t first);

struct GeometryFit {
  PathVector parameters = PathVector::Zero();
  PathMatrix covariance = PathMatrix::Zero();  ///< zero for parameters held fixed
  double cost =
      0.0;  ///< half the sum of squared whitened residuals after robust loss, priors included
  double prior_chi2 = 0.0;  ///< sum of squares of the metric priors' residuals alone
};

/// Parameters that the problem does not hold fixed.
std::vector<int> free_parameters(const GeometryProblem& problem);

/// Half the robust sum of squares at `parameters`; nothing where a lamp would lie behind the
/// camera.
std::optional<double> geometry_cost(const GeometryProblem& problem, const PathVector& parameters);

enum class Slopes { none, of_path, of_path_and_steps };

/// Residuals of the same, bearings first; slopes by `free` and, where asked for, by the sizes of
/// the setting's acceleration steps.
std::optional<Residuals> geometry_residuals(const GeometryProblem& problem,
                                            const PathVector& parameters,
                                            const std::vector<int>& free, Slopes slopes);

/// Least squares from `start` (Levenberg-Marquardt, Huber loss per lamp).
/// Misses: not_converged, bad_fit (no lengths of the order known explain the bearings),
/// unobservable (the information matrix is singular).
Outcome<GeometryFit> fit_geometry(const GeometryProblem& problem, const PathVector& start);

/// Residuals of the observations, whitened by their nominal sigmas (not by sigma_factor); one
/// column per observation.
Eigen::Matrix2Xd bearing_residuals(const GeometryProblem& problem, const PathVector& parameters);

}  // namespace vildar
