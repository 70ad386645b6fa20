#include "optics/lamp_beam.h"

#include <Eigen/Geometry>

#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/quantity.h"
#include "optics/camera.h"

namespace vildar {
namespace {

Eigen::Matrix3d vehicle_from_lamp(const LampAim& aim) {
  return (Eigen::AngleAxisd(aim.yaw_rad, Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(-aim.pitch_rad, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(aim.roll_rad, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

/// Midpoint rule over the half sphere ahead, on nodes that crowd toward the axis as sinh does: 0.04
/// degrees apart there, where the cut-off is, 2 degrees at the rim.
template <class Beam>
double forward_flux_lm(const Beam& beam) {
  constexpr int kNodes = 600;
  constexpr double kCrowding = 4.0;
  const double step = 2.0 * kCrowding / kNodes;
  const double scale_rad = 0.5 * kPi / std::sinh(kCrowding);
  double flux_lm = 0.0;
  for (int i = 0; i < kNodes; ++i) {
    const double across = -kCrowding + (i + 0.5) * step;
    const double azimuth_rad = scale_rad * std::sinh(across);
    double column = 0.0;
    for (int j = 0; j < kNodes; ++j) {
      const double up = -kCrowding + (j + 0.5) * step;
      const double elevation_rad = scale_rad * std::sinh(up);
      column +=
          beam.intensity_cd(azimuth_rad, elevation_rad) * std::cos(elevation_rad) * std::cosh(up);
    }
    flux_lm += column * std::cosh(across);
  }
  return flux_lm * (scale_rad * step) * (scale_rad * step);
}

double shape_flux_lm(const TableBeam& beam) { return beam.table->flux_lm(); }
template <class Beam>
double shape_flux_lm(const Beam& beam) {
  return forward_flux_lm(beam);
}

}  // namespace

LampBeam::LampBeam(Shape shape, const LampAim& aim, double scale)
    : shape_(std::move(shape)),
      lamp_from_vehicle_(vehicle_from_lamp(aim).transpose()),
      scale_(scale) {
  if (!(scale >= 0.0) || !std::isfinite(scale))
    throw std::invalid_argument("lamp beam: scale must be finite and not negative");
  if (const auto* table = std::get_if<TableBeam>(&shape_); table && !table->table)
    throw std::invalid_argument("lamp beam: the table is missing");
}

double LampBeam::intensity_cd(double azimuth_rad, double elevation_rad) const {
  return intensity_cd(Eigen::Vector3d(std::cos(elevation_rad) * std::cos(azimuth_rad),
                                      std::cos(elevation_rad) * std::sin(azimuth_rad),
                                      std::sin(elevation_rad)));
}

double LampBeam::intensity_cd(const Eigen::Vector3d& direction) const {
  const Bearing bearing = bearing_of(lamp_from_vehicle_ * direction);
  return scale_ * std::visit(
                      [&](const auto& shape) {
                        return shape.intensity_cd(bearing.azimuth_rad, bearing.elevation_rad);
                      },
                      shape_);
}

double LampBeam::flux_lm() const {
  return scale_ * std::visit([](const auto& shape) { return shape_flux_lm(shape); }, shape_);
}

Eigen::Vector3d vehicle_from_road(const Eigen::Vector3d& vector_road, double heading_rad,
                                  double pitch_rad) {
  return vehicle_from_lamp({heading_rad, pitch_rad, 0.0}).transpose() * vector_road;
}

}  // namespace vildar
