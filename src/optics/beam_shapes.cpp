#include "optics/beam_shapes.h"

#include <algorithm>
#include <cmath>

#include "core/quantity.h"

namespace vildar {
namespace {

constexpr double kDegree_rad = radians_from_degrees(1.0);

double bell(double value, double sigma) {
  const double scaled = value / sigma;
  return std::exp(-0.5 * scaled * scaled);
}

/// max(value, 0) with its corner rounded over about `radius`.
double soft_positive(double value, double radius) {
  return std::max(value, 0.0) + radius * std::log1p(std::exp(-std::abs(value) / radius));
}

/// Cosine of the angle off the axis; 0 for directions behind the lamp.
double forward_cosine(double azimuth_rad, double elevation_rad) {
  return std::max(0.0, std::cos(azimuth_rad) * std::cos(elevation_rad));
}

/// Elevation at which the logistic edge of the low beam falls to a half. `kerb_rad` is the angle
/// toward the kerb. The sharpest fall of the logarithm, which adjustment and sharpness are judged
/// by, lies a fifth of a degree higher.
double cutoff_rad(double kerb_rad) {
  constexpr double kLevel_rad = -0.78 * kDegree_rad;
  constexpr double kArmSlope = 0.26794919243112270;  // tan 15 degrees
  constexpr double kArmEnd_rad = 7.0 * kDegree_rad;
  const double along_arm_rad = soft_positive(kerb_rad, 0.25 * kDegree_rad) -
                               soft_positive(kerb_rad - kArmEnd_rad, 0.6 * kDegree_rad);
  return kLevel_rad + kArmSlope * along_arm_rad;
}

/// What the low beam would be without its cut-off.
double uncut_low_beam_cd(double kerb_rad, double elevation_rad) {
  const double hot_aside_rad = kerb_rad - 1.7 * kDegree_rad;
  const double hot_sigma_rad = (hot_aside_rad < 0.0 ? 2.6 : 4.2) * kDegree_rad;
  const double hot_below_rad = elevation_rad + 1.0 * kDegree_rad;
  const double hot_cd =
      12500.0 * bell(hot_aside_rad, hot_sigma_rad) * bell(hot_below_rad, 0.9 * kDegree_rad);
  const double foreground = bell(std::min(hot_below_rad, 0.0), 3.2 * kDegree_rad);
  const double wide_cd =
      5200.0 * bell(kerb_rad, 14.0 * kDegree_rad) + 900.0 * bell(kerb_rad, 32.0 * kDegree_rad);
  return hot_cd + wide_cd * foreground;
}

}  // namespace

double LambertianBeam::intensity_cd(double azimuth_rad, double elevation_rad) const {
  return on_axis_cd * std::pow(forward_cosine(azimuth_rad, elevation_rad), order);
}

double LowBeam::intensity_cd(double azimuth_rad, double elevation_rad) const {
  constexpr double kEdgeWidth_rad = 0.13 * kDegree_rad;
  const double kerb_rad = side == TrafficSide::right ? -azimuth_rad : azimuth_rad;
  const double stray_cd =
      210.0 * bell(kerb_rad, 30.0 * kDegree_rad) * bell(elevation_rad, 12.0 * kDegree_rad);
  const double passed =
      1.0 / (1.0 + std::exp((elevation_rad - cutoff_rad(kerb_rad)) / kEdgeWidth_rad));
  return (stray_cd + passed * uncut_low_beam_cd(kerb_rad, elevation_rad)) *
         forward_cosine(azimuth_rad, elevation_rad);
}

double HighBeam::intensity_cd(double azimuth_rad, double elevation_rad) const {
  const double hot_cd =
      48000.0 * bell(azimuth_rad, 3.2 * kDegree_rad) * bell(elevation_rad, 1.6 * kDegree_rad);
  const double wide_cd =
      6500.0 * bell(azimuth_rad, 9.0 * kDegree_rad) * bell(elevation_rad, 3.5 * kDegree_rad);
  const double spread_cd =
      500.0 * bell(azimuth_rad, 25.0 * kDegree_rad) * bell(elevation_rad, 8.0 * kDegree_rad);
  return (hot_cd + wide_cd + spread_cd) * forward_cosine(azimuth_rad, elevation_rad);
}

double SignalBeam::intensity_cd(double azimuth_rad, double elevation_rad) const {
  constexpr double kWideShare = 0.1;
  const double main =
      bell(azimuth_rad, 13.0 * kDegree_rad) * bell(elevation_rad, 7.5 * kDegree_rad);
  const double wide = bell(elevation_rad, 20.0 * kDegree_rad);
  return on_axis_cd * ((1.0 - kWideShare) * main + kWideShare * wide) *
         forward_cosine(azimuth_rad, elevation_rad);
}

}  // namespace vildar
