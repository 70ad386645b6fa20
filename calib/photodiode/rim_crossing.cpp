#include "calib/photodiode/rim_crossing.h"

#include <array>
#include <cmath>

#include <ceres/jet.h>

#include "optics/incidence.h"

namespace vildar {
namespace {

using PathJet = ceres::Jet<double, kPathParameters>;

// Of a lamp as a photodiode sees it.
class View {
 public:
  View(const Trajectory& way, double side, const PhotodiodeSite& photodiode)
      : way_(way),
        side_(side),
        axis_(axis_of(photodiode)),
        half_view_rad_(photodiode.half_field_of_view_rad) {
    for (int axis = 0; axis < 3; ++axis)
      receiver_from_camera_m_[axis] = photodiode.position_m[static_cast<std::size_t>(axis)].mean -
                                      way.problem.setting.camera_m[axis];
  }

  template <class T>
  Eigen::Matrix<T, 3, 1> toward_m(const T* path, double time_s) const {
    const double tau_s = time_s - way_.problem.reference_s;
    const Eigen::Matrix<T, 3, 1> lamp_m =
        lamp_from_camera_m(path, way_.problem.setting, tau_s, side_,
                           way_.ego.deviation(way_.problem.reference_s, time_s));
    return lamp_m - receiver_from_camera_m_.cast<T>();
  }
  double distance_m(double time_s) const {
    return toward_m(way_.fit.parameters.data(), time_s).norm();
  }

  // By how much the lamp stands within the rim; falls as it comes nearer.
  template <class T>
  T inside_rad(const T* path, double time_s) const {
    using std::acos;
    using std::sqrt;
    const Eigen::Matrix<T, 3, 1> toward = toward_m(path, time_s);
    return half_view_rad_ - acos(toward.dot(axis_.cast<T>()) / sqrt(toward.squaredNorm()));
  }
  double inside_rad(double time_s) const { return inside_rad(way_.fit.parameters.data(), time_s); }

 private:
  const Trajectory& way_;
  double side_;
  Eigen::Vector3d axis_, receiver_from_camera_m_;
  double half_view_rad_;
};

std::optional<double> leaves_at_s(const View& view, double from_s, double to_s) {
  constexpr double kStep_s = 0.02;
  constexpr int kHalvings = 24;
  if (!(view.inside_rad(from_s) > 0.0)) return std::nullopt;
  for (double in_s = from_s; in_s < to_s; in_s += kStep_s) {
    double inside_s = in_s, outside_s = in_s + kStep_s;
    if (view.inside_rad(outside_s) > 0.0) continue;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle_s = 0.5 * (inside_s + outside_s);
      (view.inside_rad(middle_s) > 0.0 ? inside_s : outside_s) = middle_s;
    }
    return inside_s;
  }
  return std::nullopt;
}

}  // namespace

std::optional<RimCrossing> rim_crossing(const Trajectory& way, double side,
                                        const PhotodiodeSite& photodiode) {
  constexpr double kInstant_s = 1e-3, kLongest_s = 4.0;
  constexpr double kUnseen_mps2 = 1.0;
  const View view(way, side, photodiode);
  const auto at_s = leaves_at_s(view, way.from_s, way.to_s + kLongest_s);
  if (!at_s) return std::nullopt;
  const double rate_rad_per_s =
      (view.inside_rad(*at_s + kInstant_s) - view.inside_rad(*at_s - kInstant_s)) /
      (2.0 * kInstant_s);
  const MotionState state = way.at(*at_s);
  if (!(rate_rad_per_s < 0.0) || !(state.closing_mps > 0.0)) return std::nullopt;
  std::array<PathJet, kPathParameters> path;
  for (int i = 0; i < kPathParameters; ++i)
    path[static_cast<std::size_t>(i)] = PathJet(way.fit.parameters[i], i);
  const PathVector by_path = -view.inside_rad(path.data(), *at_s).v / rate_rad_per_s;
  // What more it has driven by then it is early by.
  const auto& steps = way.problem.setting.steps;
  const double scale_m = std::exp(way.fit.parameters[kLogScale]);
  Eigen::VectorXd by_step(static_cast<Eigen::Index>(steps.size()));
  for (std::size_t k = 0; k < steps.size(); ++k)
    by_step[static_cast<Eigen::Index>(k)] =
        -scale_m * steps[k].way(*at_s - way.problem.reference_s) / state.closing_mps;
  const double unseen_s = std::max(0.0, *at_s - way.to_s);
  const double std_s = std::hypot(way.std_of(by_path, by_step),
                                  0.5 * kUnseen_mps2 * unseen_s * unseen_s / state.closing_mps);
  return RimCrossing{*at_s, std_s, -1.0 / rate_rad_per_s, view.distance_m(*at_s)};
}

}  // namespace vildar
