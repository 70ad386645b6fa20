#pragma once

#include <variant>

#include <Eigen/Core>

#include "optics/beam_shapes.h"
#include "optics/candela_table.h"

namespace vildar {

/// How a lamp is turned in the vehicle: yaw to the left, pitch up, roll clockwise as seen from
/// behind, applied in that order, intrinsic. A misaimed lamp, or a vehicle that pitches.
struct LampAim {
  double yaw_rad = 0.0;
  double pitch_rad = 0.0;
  double roll_rad = 0.0;
};

/// Luminous intensity of one lamp by direction, far from it (the lamp taken as a point).
class LampBeam {
 public:
  using Shape = std::variant<LambertianBeam, LowBeam, HighBeam, SignalBeam, TableBeam>;

  /// `scale` multiplies every intensity; >= 0, throws std::invalid_argument otherwise.
  explicit LampBeam(Shape shape, const LampAim& aim = {}, double scale = 1.0);

  /// Azimuth positive to the left, elevation positive up, (0, 0) straight ahead of the vehicle.
  double intensity_cd(double azimuth_rad, double elevation_rad) const;
  /// The same toward a direction in the vehicle's axes (x ahead, y left, z up), of any length > 0.
  double intensity_cd(const Eigen::Vector3d& direction) const;

  /// Light sent out in all directions; exact for tables, by quadrature to 1e-4 for the others.
  double flux_lm() const;

 private:
  Shape shape_;
  Eigen::Matrix3d lamp_from_vehicle_;
  double scale_;
};

/// Turns a road-frame vector into the axes of a vehicle that heads `heading_rad` (anticlockwise
/// from +x, the way its lamps point) and is pitched up by `pitch_rad`.
Eigen::Vector3d vehicle_from_road(const Eigen::Vector3d& vector_road, double heading_rad,
                                  double pitch_rad);

}  // namespace vildar
