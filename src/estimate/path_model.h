#pragma once

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "optics/camera.h"
#include "optics/ego_motion.h"
#include "optics/road.h"

namespace vildar {

/// The trajectory's unknowns. All lengths but one are ratios to the along-road distance X from the
/// camera at the reference time, so that on a straight road no bearing depends on ln X: it enters
/// through metric priors alone.
enum PathParameter : int {
  kLogScale,       ///< ln X, X in metres
  kClosingRate,    ///< closing speed over X at the reference time, 1/s
  kAcceleration,   ///< rate of change of the closing speed over X, 1/s^2
  kLateral,        ///< lateral offset from the camera over X
  kDrop,           ///< camera height less lamp height, over X
  kLogSeparation,  ///< ln of lamp separation over X
  kLogRadius,      ///< ln of the road's radius (line y = 0) over X
  kStraight,       ///< x of the bend's begin over X; free where that is not known exactly
  kYaw,            ///< turns of the camera from the site's mean pose, rad
  kPitch,
  kRoll,
  kLogFocal,  ///< ln of the focal length over the site's
  kHeading,   ///< of the camera's own vehicle off the road's at the reference time, rad
  kEgoDelay,  ///< to be added to the stamps of the trace of its motion, s
  kSquat,     ///< pitch of the camera per own acceleration, nose up: positive, rad per m/s^2
  kOwnSwing,  ///< first of OwnWay's swings, or, where the vehicle itself weaves, of its way, m; on
              ///< a straight road over X
  kPathParameters = kOwnSwing + kOwnSwings,
};
using PathVector = Eigen::Matrix<double, kPathParameters, 1>;
using PathMatrix = Eigen::Matrix<double, kPathParameters, kPathParameters>;

/// Which way an acceleration goes.
enum class Along { road, across };

/// What changes: the acceleration at a time, or all along it, or the speed all along.
enum class Departs { from_a_time, by_acceleration, by_speed };

/// A change of the motion. From a time on: beyond it, seen from the reference time, the
/// acceleration is another.
struct AccelerationStep {
  double tau_s = 0.0;  ///< after the reference time; before it the step is taken backwards
  double size = 0.0;   ///< of the acceleration toward the camera, or to the left, over X, 1/s^2
  Along along = Along::road;
  Departs departs = Departs::from_a_time;  ///< by_speed: `size` is of the speed over X and a second
  double unit = 1.0;                       ///< of `size`

  /// How far beyond the step; zero on this side of it.
  double beyond_s(double at_s) const {
    if (departs != Departs::from_a_time) return at_s;
    const double beyond = at_s - tau_s;
    return (tau_s > 0.0) == (beyond > 0.0) ? beyond : 0.0;
  }
  /// Rate of the way per unit of size.
  double rate(double at_s) const {
    return unit * (departs == Departs::by_speed ? 1.0 : beyond_s(at_s));
  }
  /// Way per unit of size.
  double way(double at_s) const {
    const double beyond = beyond_s(at_s);
    return unit * (departs == Departs::by_speed ? at_s : 0.5 * beyond * beyond);
  }
  /// Integral of that over the path of one who drives at `speed` + `acceleration` t, per unit of
  /// size.
  template <class T>
  T swept(double at_s, const T& speed, const T& acceleration) const {
    if (departs == Departs::by_speed)
      return unit * at_s * at_s * (0.5 * speed + at_s / 3.0 * acceleration);
    const double beyond = beyond_s(at_s);
    return unit * beyond * beyond * beyond *
           ((speed + (at_s - beyond) * acceleration) / 6.0 + 0.125 * beyond * acceleration);
  }
};

inline double value_of(double value) { return value; }
template <class Jet>
double value_of(const Jet& value) {
  return value.a;
}

/// What the site file knows of camera and road, and how the vehicle departs from constant
/// acceleration in its lane.
struct PathSetting {
  Eigen::Vector3d camera_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d camera_from_road = Eigen::Matrix3d::Identity();  ///< mean pose
  double yaw_rad = 0.0, pitch_rad = 0.0, roll_rad = 0.0;           ///< of the same
  bool turns = false;         ///< the pose has a std, so that p[kYaw..kRoll] may differ from zero
  bool focal_unsure = false;  ///< p[kLogFocal] may differ from zero
  bool ego_unsure = false;    ///< p[kHeading..] may differ from zero
  bool weaves = false;        ///< p[kOwnSwing..] are the vehicle's, across its lane
  double own_mps = 0.0;       ///< of a camera that drives
  double bend = 0.0;          ///< as in path_point
  double straight_m = 0.0;
  bool straight_unsure = false;  ///< p[kStraight] stands for straight_m
  std::vector<AccelerationStep> steps;

  /// What the steps add to the closing rate (to the one to the left), over X, by a time after the
  /// reference.
  double departed_rate(double tau_s, Along along = Along::road) const {
    double rate = 0.0;
    for (const AccelerationStep& step : steps)
      if (step.along == along) rate += step.size * step.rate(tau_s);
    return rate;
  }
  /// And to the rate of change of that.
  double departed_acceleration(double tau_s) const {
    double sum = 0.0;
    for (const AccelerationStep& step : steps)
      if (step.along == Along::road)
        sum += step.beyond_s(tau_s) == 0.0 ? 0.0 : step.unit * step.size;
    return sum;
  }
  /// And to the way driven; exact to first order for a ceres::Jet.
  template <class Time>
  Time departed(const Time& tau_s, Along along = Along::road) const {
    if constexpr (std::is_same_v<Time, double>) {
      double way = 0.0;
      for (const AccelerationStep& step : steps)
        if (step.along == along) way += step.size * step.way(tau_s);
      return way;
    } else {
      return departed(tau_s.a, along) + departed_rate(tau_s.a, along) * (tau_s - tau_s.a);
    }
  }
  /// Whether the vehicle leaves its line across the road: the first of its steps then does.
  bool crosses() const { return !steps.empty() && steps.front().along == Along::across; }
};
PathSetting path_setting(const CameraSite& camera, const RoadSite& road);

/// Length of the vehicle's lane per length of the road's line y = 0: concentric lanes differ.
template <class T>
T lane_way_share(const T* p, const PathSetting& setting) {
  using std::exp;
  if (setting.bend == 0.0) return T(1.0);
  const T scale_m = exp(p[kLogScale]);
  return 1.0 - setting.bend * (setting.camera_m.y() + scale_m * p[kLateral]) /
                   (scale_m * exp(p[kLogRadius]));
}

/// Metres along the road from x = 0 to where the bend begins.
template <class T>
T bend_begins_m(const T* p, const PathSetting& setting) {
  using std::exp;
  return setting.straight_unsure ? T(exp(p[kLogScale]) * p[kStraight]) : T(setting.straight_m);
}

/// One who crosses a bend comes farther while inside the line of the reference time, and less far
/// outside of it, than along that line at the same speed: by how much since that time, over X,
/// where `swept` gives the integral of the way across, over X, along a path of this speed (m/s) and
/// acceleration (m/s^2) to a time.
template <class T, class Swept>
T gained_inside(const T* p, const PathSetting& setting, double tau_s, const Swept& swept) {
  using std::exp;
  const T scale_m = exp(p[kLogScale]);
  const T speed_mps = scale_m * p[kClosingRate] - setting.own_mps;
  const T acceleration_mps2 = scale_m * p[kAcceleration];
  const double speed = value_of(speed_mps);
  const double to_bend_m =
      setting.camera_m.x() + value_of(scale_m) - value_of(bend_begins_m(p, setting));
  const double square = speed * speed + 2.0 * value_of(acceleration_mps2) * to_bend_m;
  const double bend_s = square < 0.0
                            ? std::copysign(INFINITY, speed)  // it never comes there
                            : 2.0 * to_bend_m / (speed + std::copysign(std::sqrt(square), speed));
  const auto on_bend_s = [&](double at_s) {
    return speed > 0.0 ? std::min(at_s, bend_s) : std::max(at_s, bend_s);
  };
  const T lane_radius_m =
      scale_m * exp(p[kLogRadius]) - setting.bend * (setting.camera_m.y() + scale_m * p[kLateral]);
  return setting.bend / lane_radius_m *
         (swept(on_bend_s(tau_s), speed_mps, acceleration_mps2) -
          swept(on_bend_s(0.0), speed_mps, acceleration_mps2));
}

/// Ground point and heading of the vehicle `tau_s` after the reference time, in the road frame of
/// that time. A moving camera takes this frame along the road's line y = 0 at its speed of the
/// reference time, the closing speed being along the vehicle's lane; `ahead_m` is by how much more
/// than that it has driven.
template <class T, class Time>
PathPoint<T> vehicle_point(const T* p, const PathSetting& setting, const Time& tau_s,
                           const T& ahead_m = T(0.0)) {
  using std::cos;
  using std::exp;
  using std::sin;
  const T scale_m = exp(p[kLogScale]);
  T along_m = setting.camera_m.x() +
              scale_m * (1.0 - tau_s * (p[kClosingRate] + 0.5 * tau_s * p[kAcceleration]) -
                         setting.departed(tau_s));
  if (ahead_m != T(0.0)) along_m -= lane_way_share(p, setting) * ahead_m;
  const T lateral_m = setting.camera_m.y() + scale_m * p[kLateral];
  const T radius_m = setting.bend == 0.0 ? T(0.0) : scale_m * exp(p[kLogRadius]);
  const bool crosses = setting.crosses();
  if (crosses && setting.bend != 0.0)
    along_m -= scale_m * gained_inside(p, setting, value_of(tau_s),
                                       [&](double at_s, const T& speed, const T& acceleration) {
                                         T sum(0.0);
                                         for (const AccelerationStep& step : setting.steps)
                                           if (step.along == Along::across)
                                             sum +=
                                                 step.size * step.swept(at_s, speed, acceleration);
                                         return sum;
                                       });
  PathPoint<T> place =
      setting.straight_unsure
          ? path_point(along_m, lateral_m, setting.bend, bend_begins_m(p, setting), radius_m)
          : path_point(along_m, lateral_m, setting.bend, setting.straight_m, radius_m);
  if (!crosses) return place;
  const T aside_m = scale_m * setting.departed(tau_s, Along::across);
  if (setting.bend != 0.0) place.x_m -= aside_m * sin(place.heading_rad);
  place.y_m += setting.bend != 0.0 ? aside_m * cos(place.heading_rad) : aside_m;
  return place;
}

/// How far a vehicle that crosses goes to the left for each metre that it drives toward where the
/// camera is.
template <class T>
T left_per_ahead(const T* p, const PathSetting& setting, double tau_s) {
  using std::exp;
  const T scale_m = exp(p[kLogScale]);
  const T closing = p[kClosingRate] + tau_s * p[kAcceleration] + setting.departed_rate(tau_s);
  return scale_m * setting.departed_rate(tau_s, Along::across) /
         (scale_m * closing - setting.own_mps);
}

/// From the camera to a lamp, road axes of the camera's own vehicle, metres. `side` as in
/// LampObservation.
template <class T>
Eigen::Matrix<T, 3, 1> lamp_from_camera_m(const T* p, const PathSetting& setting, double tau_s,
                                          double side, const EgoDeviation& ego) {
  using std::cos;
  using std::exp;
  using std::sin;
  const T scale_m = exp(p[kLogScale]);
  T heading_rad(ego.heading_rad), left_m(ego.left_m), ahead_m(ego.ahead_m);
  if (setting.ego_unsure) {
    const T late_s = p[kEgoDelay];
    heading_rad += late_s * ego.by_delay.heading_rad;
    left_m += late_s * ego.by_delay.left_m;
    for (int k = 0; k < kOwnSwings; ++k) {
      const EgoDeviation::Swing& swing = ego.by_swing[static_cast<std::size_t>(k)];
      heading_rad += p[kOwnSwing + k] * swing.heading_rad;
      left_m += p[kOwnSwing + k] * swing.left_m;
    }
    const T along_m = ego.along_m + late_s * ego.by_delay.along_m;
    const T c = cos(p[kHeading]), s = sin(p[kHeading]);
    heading_rad += p[kHeading];
    ahead_m += c * along_m - s * left_m - ego.along_m;
    left_m = s * along_m + c * left_m;
  }
  const PathPoint<T> place = vehicle_point(p, setting, tau_s, ahead_m);
  if (setting.bend != 0.0 && ego.way_m != 0.0) {
    const T off_per_m = ego.curvature_per_m - setting.bend / (scale_m * exp(p[kLogRadius]));
    heading_rad += off_per_m * ego.way_m;
    left_m += 0.5 * off_per_m * ego.way_m * ego.way_m;
  }
  T x_m = place.x_m, y_m = place.y_m - left_m;
  if (side != 0.0 || setting.weaves) {
    T offset_m = side == 0.0 ? T(0.0) : side * scale_m * exp(p[kLogSeparation]);
    const T weaves_by_m = setting.bend != 0.0 ? T(1.0) : scale_m;
    for (int k = 0; setting.weaves && k < kOwnSwings; ++k)
      offset_m += weaves_by_m * p[kOwnSwing + k] * ego.by_swing[static_cast<std::size_t>(k)].left_m;
    if (setting.bend != 0.0) {
      T faces_rad = place.heading_rad;
      if (setting.crosses()) faces_rad -= left_per_ahead(p, setting, tau_s);
      x_m -= offset_m * sin(faces_rad);
      y_m += offset_m * cos(faces_rad);
    } else {
      y_m += offset_m;
      if (setting.crosses()) x_m += offset_m * left_per_ahead(p, setting, tau_s);
    }
  }
  if (setting.ego_unsure || heading_rad != T(0.0)) {
    const T c = cos(heading_rad), s = sin(heading_rad);
    const T turned_m = c * x_m + s * y_m;
    y_m = c * y_m - s * x_m;
    x_m = turned_m;
  }
  return {x_m - setting.camera_m.x(), y_m - setting.camera_m.y(), -scale_m * p[kDrop]};
}

/// Camera axes of a road-frame direction, for a camera turned by p[kYaw..kRoll] from its mean pose.
/// Across its view they are stretched by p[kLogFocal]: image places by the site's focal length come
/// out as they are seen.
template <class T>
Eigen::Matrix<T, 3, 1> camera_axes(const T* p, const PathSetting& setting,
                                   const Eigen::Matrix<T, 3, 1>& ray) {
  using std::cos;
  using std::exp;
  using std::sin;
  Eigen::Matrix<T, 3, 1> axes;
  if (setting.turns) {
    // Yaw, pitch and roll undone in their order; ahead, left and up are the body's axes.
    const T yaw_rad = setting.yaw_rad + p[kYaw];
    const T pitch_rad = setting.pitch_rad + p[kPitch];
    const T roll_rad = setting.roll_rad + p[kRoll];
    const T level = cos(yaw_rad) * ray.x() + sin(yaw_rad) * ray.y();
    const T left = cos(yaw_rad) * ray.y() - sin(yaw_rad) * ray.x();
    const T ahead = cos(pitch_rad) * level + sin(pitch_rad) * ray.z();
    const T up = cos(pitch_rad) * ray.z() - sin(pitch_rad) * level;
    axes = {-(cos(roll_rad) * left + sin(roll_rad) * up), sin(roll_rad) * left - cos(roll_rad) * up,
            ahead};
  } else {
    axes = setting.camera_from_road.cast<T>() * ray;
  }
  if (setting.focal_unsure) axes.template head<2>() *= exp(p[kLogFocal]);
  return axes;
}

}  // namespace vildar
