#pragma once

#include <Eigen/Core>

#include "core/quantity.h"
#include "types/site.h"

namespace vildar {

/// Where a vehicle stands as the paper measures it, sensor at the origin.
struct PaperPlace {
  double range_m = 0.0;          ///< R, along the sensor's view
  double perpendicular_m = 0.0;  ///< d or d_c + d_o, across it
  double distance_m = 0.0;       ///< D
  double incidence_rad = 0.0;    ///< theta, with cos(theta) = R / D; in [0, pi]
};

/// Straight road, paper fig. 1a. Throws std::domain_error where R and d are both zero.
PaperPlace straight_place(Metres range, Metres perpendicular);

/// The paper's curved road, fig. 1b: an arc of radius r_c, tangent at beta = 0 to a straight piece.
struct PaperCurve {
  double radius_m = 40.0;   ///< r_c, of the vehicle's own path
  double straight_m = 0.0;  ///< R_o
  double lateral_m = 0.0;   ///< d_o
};

/// Place at arc angle beta, eqs. (17) to (19). Throws std::domain_error at distance zero or unless
/// r_c > 0.
PaperPlace curved_place(const PaperCurve& curve, Radians arc_angle);

/// Where a photodiode looks: a unit vector in the road frame.
Eigen::Vector3d axis_of(const PhotodiodeSite& photodiode);

}  // namespace vildar
