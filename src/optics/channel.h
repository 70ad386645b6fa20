#pragma once

#include "core/quantity.h"

namespace vildar {

/// Lambertian order n = -ln 2 / ln cos(half-power angle), paper eq. (2). Domain (0, pi/2); throws
/// std::domain_error outside.
double lambertian_order(Radians half_power_angle);

/// C = (n + 1) A / (2 pi), paper eq. (5), for an area in square metres.
double lambertian_gain(double order, double area_m2);

/// Ratio from decibels of optical power, 10 log10.
double ratio_from_db(double gain_db);
double db_from_ratio(double ratio);

/// The two channel laws of the paper in one: P = K D^-gamma cos^m(theta), with cos(theta) = R / D.
/// m = 0 is the simulated channel (eq. 8); m = n + 1 the Lambertian one (eq. 6).
struct PowerLaw {
  double gain_w = 1.0;  ///< K: power at D = 1 m, on axis, lamp power included
  double path_loss_exponent = 2.0;
  double cosine_exponent = 0.0;

  /// Power at range R along the road and perpendicular distance d. Zero behind the lamp (R <= 0
  /// with m > 0). Throws std::domain_error where D is not positive.
  double power_w(double range_m, double perpendicular_m) const;
};

}  // namespace vildar
