#include "optics/camera.h"

#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "core/quantity.h"

namespace vildar {
namespace {

// Radial scale of the fisheye (equidistant polynomial) model at angle theta from the axis.
double fisheye_radius(const std::array<double, 5>& k, double theta_rad) {
  const double t2 = theta_rad * theta_rad;
  return theta_rad * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
}

Eigen::Vector2d distorted(const CameraSite& site, const Eigen::Vector2d& normalized) {
  const auto& k = site.distortion_coefficients;
  const double x = normalized.x(), y = normalized.y();
  const double r2 = x * x + y * y;
  switch (site.distortion) {
    case DistortionModel::none: return normalized;
    case DistortionModel::brown: {
      const double radial = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
      return {x * radial + 2.0 * k[2] * x * y + k[3] * (r2 + 2.0 * x * x),
              y * radial + k[2] * (r2 + 2.0 * y * y) + 2.0 * k[3] * x * y};
    }
    case DistortionModel::fisheye: {
      const double r = std::sqrt(r2);
      if (r < 1e-12) return normalized;
      return normalized * (fisheye_radius(k, std::atan(r)) / r);
    }
  }
  return normalized;
}

// Normalized radius at which the radial mapping stops growing; beyond it two rays share a pixel.
double one_to_one_radius(const CameraSite& site) {
  if (site.distortion == DistortionModel::none) return std::numeric_limits<double>::infinity();
  const auto& k = site.distortion_coefficients;
  constexpr double kStep = 1e-3;
  if (site.distortion == DistortionModel::fisheye) {
    constexpr double kWidest_rad = 0.5 * kPi - kStep;
    for (double theta_rad = kStep; theta_rad < kWidest_rad; theta_rad += kStep)
      if (fisheye_radius(k, theta_rad + kStep) <= fisheye_radius(k, theta_rad))
        return std::tan(theta_rad);
    return std::tan(kWidest_rad);
  }
  constexpr double kWidest = 10.0;
  for (double r = kStep; r < kWidest; r += kStep) {
    const double r2 = r * r;
    if (1.0 + r2 * (3.0 * k[0] + r2 * (5.0 * k[1] + r2 * 7.0 * k[4])) <= 0.0) return r;
  }
  return kWidest;
}

}  // namespace

Bearing bearing_of(const Eigen::Vector3d& ray_road) {
  return {std::atan2(ray_road.y(), ray_road.x()),
          std::atan2(ray_road.z(), std::hypot(ray_road.x(), ray_road.y()))};
}

Eigen::Matrix3d camera_from_road_rotation(double yaw_rad, double pitch_rad, double roll_rad) {
  // Body axes: x forward, y left, z up. Positive pitch lifts the nose: a turn about -y.
  const Eigen::Matrix3d road_from_body = (Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()) *
                                          Eigen::AngleAxisd(-pitch_rad, Eigen::Vector3d::UnitY()) *
                                          Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitX()))
                                             .toRotationMatrix();
  Eigen::Matrix3d camera_from_body;
  camera_from_body << 0.0, -1.0, 0.0, 0.0, 0.0, -1.0, 1.0, 0.0, 0.0;
  return camera_from_body * road_from_body.transpose();
}

Camera::Camera(const CameraSite& site)
    : site_(site),
      position_m_(site.position_m[0].mean, site.position_m[1].mean, site.position_m[2].mean),
      camera_from_road_(
          camera_from_road_rotation(site.yaw_rad.mean, site.pitch_rad.mean, site.roll_rad.mean)),
      distortion_radius_limit_(one_to_one_radius(site)) {}

double Camera::focal_px() const { return std::sqrt(site_.focal_px[0] * site_.focal_px[1]); }

std::optional<Eigen::Vector2d> Camera::project(const Eigen::Vector3d& point_road_m) const {
  const Eigen::Vector3d point_camera_m = camera_from_road_ * (point_road_m - position_m_);
  if (!(point_camera_m.z() > 1e-9)) return std::nullopt;
  return pixel_from_normalized(point_camera_m.head<2>() / point_camera_m.z());
}

std::optional<Eigen::Vector2d> Camera::pixel_from_normalized(
    const Eigen::Vector2d& normalized) const {
  if (!(normalized.norm() < distortion_radius_limit_)) return std::nullopt;
  const Eigen::Vector2d bent = distorted(site_, normalized);
  return Eigen::Vector2d(site_.focal_px[0] * bent.x() + site_.principal_px[0],
                         site_.focal_px[1] * bent.y() + site_.principal_px[1]);
}

std::optional<Eigen::Vector2d> Camera::normalized_from_pixel(
    const Eigen::Vector2d& pixel_px) const {
  const Eigen::Vector2d bent((pixel_px.x() - site_.principal_px[0]) / site_.focal_px[0],
                             (pixel_px.y() - site_.principal_px[1]) / site_.focal_px[1]);
  if (site_.distortion == DistortionModel::none) return bent;
  // Newton on the distortion map, its 2x2 Jacobian by central differences; it converges in a few
  // steps inside the one-to-one radius.
  constexpr int kMostSteps = 30;
  constexpr double kStep = 1e-6;
  constexpr double kTolerance = 1e-13;
  Eigen::Vector2d guess = bent;
  if (site_.distortion == DistortionModel::fisheye) {
    const double r = bent.norm();
    if (r > 1e-12) guess = bent * (std::tan(std::min(r, 1.5)) / r);
  }
  for (int step = 0; step < kMostSteps; ++step) {
    const Eigen::Vector2d error = distorted(site_, guess) - bent;
    Eigen::Matrix2d jacobian;
    for (int axis = 0; axis < 2; ++axis) {
      Eigen::Vector2d offset = Eigen::Vector2d::Zero();
      offset[axis] = kStep;
      jacobian.col(axis) =
          (distorted(site_, guess + offset) - distorted(site_, guess - offset)) / (2.0 * kStep);
    }
    if (!(std::abs(jacobian.determinant()) > 1e-12)) return std::nullopt;
    guess -= jacobian.inverse() * error;
    if (!guess.allFinite()) return std::nullopt;
    if (error.norm() < kTolerance * (1.0 + bent.norm())) break;
  }
  const bool found = (distorted(site_, guess) - bent).norm() < 1e-9 * (1.0 + bent.norm());
  if (!found || !(guess.norm() < distortion_radius_limit_)) return std::nullopt;
  return guess;
}

std::optional<Eigen::Vector3d> Camera::road_ray_from_pixel(const Eigen::Vector2d& pixel_px) const {
  const auto normalized = normalized_from_pixel(pixel_px);
  if (!normalized) return std::nullopt;
  return camera_from_road_.transpose() *
         Eigen::Vector3d(normalized->x(), normalized->y(), 1.0).normalized();
}

std::optional<Eigen::Vector2d> Camera::plane_point_m(const Eigen::Vector2d& pixel_px,
                                                     double height_m) const {
  const auto ray = road_ray_from_pixel(pixel_px);
  if (!ray) return std::nullopt;
  const double distance_m = (height_m - position_m_.z()) / ray->z();
  if (!(distance_m > 0.0) || !std::isfinite(distance_m)) return std::nullopt;
  return (position_m_ + distance_m * *ray).head<2>();
}

}  // namespace vildar
