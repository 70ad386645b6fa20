#include "synth/psf.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/quantity.h"

namespace vildar {
namespace {

constexpr double kSmallestNear_px = 48.0;
constexpr double kNearPerDisc = 3.0;
constexpr double kGaussianReach = 6.0;  // sigmas; beyond lies 1e-9 of the core

// The wing of discs is tabulated over ln(disc radius) and over asinh(r / (a + disc radius)), in
// units of 1 / (a + disc radius)^2: the curves of neighbouring discs then nearly coincide.
constexpr double kDiscStep = 0.2;
constexpr double kSmallestDiscLog = -4.8;  // 0.008 px: a point
constexpr int kDiscNodes = 60;             // up to 1100 px
constexpr double kRadiusStep = 0.06;
constexpr int kRadiusNodes = 84;  // up to sinh(4.9) = 67 (a + disc radius)

double standard_normal_between(double low, double high) {
  return 0.5 * (std::erf(high * std::sqrt(0.5)) - std::erf(low * std::sqrt(0.5)));
}

// Gaussian of unit flux averaged over a disc, by chords: across the disc the gaussian is a weight,
// along each chord its integral is a difference of error functions.
double gaussian_of_disc(double radius_px, double disc_px, double sigma_px) {
  const double widest_px = std::min(disc_px, kGaussianReach * sigma_px);
  const double widest_rad = std::asin(widest_px / disc_px);
  const bool whole = disc_px <= kGaussianReach * sigma_px;
  const int steps = 40;
  double sum = 0.0;
  for (int i = 0; i < steps; ++i) {
    // Where the whole disc counts, equal steps of angle take the ends of the chords gently.
    const double share = 2.0 * (i + 0.5) / steps - 1.0;
    const double across_px = whole ? disc_px * std::sin(share * widest_rad) : share * widest_px;
    const double chord_px = std::sqrt(std::max(0.0, disc_px * disc_px - across_px * across_px));
    const double step_px = whole ? 2.0 * widest_rad / steps * chord_px : 2.0 * widest_px / steps;
    sum += step_px * std::exp(-0.5 * across_px * across_px / (sigma_px * sigma_px)) *
           standard_normal_between((radius_px - chord_px) / sigma_px,
                                   (radius_px + chord_px) / sigma_px);
  }
  return sum / (std::sqrt(2.0 * kPi) * sigma_px * kPi * disc_px * disc_px);
}

// Four-point Lagrange interpolation at `share` between p[1] and p[2]; `stride` apart.
double cubic(const double* p, double share, std::size_t stride = 1) {
  const double a = p[0], b = p[stride], c = p[2 * stride], d = p[3 * stride];
  const double x = share;
  return b + x * ((c - a / 3.0 - b / 2.0 - d / 6.0) +
                  x * ((a + c) / 2.0 - b + x * ((d - a) / 6.0 + (b - c) / 2.0)));
}

}  // namespace

double LampProfile::near(double radius_px) const {
  if (!(radius_px < near_radius_px_)) return 0.0;
  const double position = radius_px / step_px_;
  const auto below = static_cast<std::size_t>(position);
  return cubic(&near_[below], position - static_cast<double>(below));
}

double LampProfile::far(double radius_px) const {
  if (radius_px < near_radius_px_) {
    const double r2 = radius_px * radius_px;
    return extension_[0] + r2 * (extension_[1] + r2 * extension_[2]);
  }
  const auto below = static_cast<std::size_t>(radius_px);
  const double share = radius_px - static_cast<double>(below);
  const double* p = &(*far_table_)[2 * below];
  return (1.0 - share) * (p[0] + disc_px2_ * p[1]) + share * (p[2] + disc_px2_ * p[3]);
}

Psf::Psf(const PsfShape& shape, double reach_px) : shape_(shape) {
  if (!(shape.core_sigma_px >= 0.5) || !(shape.wing_share >= 0.0 && shape.wing_share < 1.0) ||
      !(shape.wing_scale_px > 0.0) || !(shape.wing_exponent > 2.0))
    throw std::invalid_argument(
        "Psf: core sigma must be >= 0.5 px, wing share in [0, 1), scale > 0, exponent > 2");
  const double a2 = shape.wing_scale_px * shape.wing_scale_px;
  const double q = shape.wing_exponent;
  const auto entries = static_cast<std::size_t>(std::ceil(reach_px)) + 3;
  far_table_.resize(2 * entries);
  for (std::size_t i = 0; i < entries; ++i) {
    const double r2 = static_cast<double>(i) * static_cast<double>(i);
    const double value = shape.wing_share * wing(static_cast<double>(i));
    far_table_[2 * i] = value;
    far_table_[2 * i + 1] = value * q * (q * r2 - 2.0 * a2) / ((a2 + r2) * (a2 + r2)) / 8.0;
  }

  disc_table_.resize(static_cast<std::size_t>(kDiscNodes) * kRadiusNodes);
  for (int i = 0; i < kDiscNodes; ++i) {
    const double disc_px = std::exp(kSmallestDiscLog + kDiscStep * i);
    const double unit_px = shape.wing_scale_px + disc_px;
    for (int j = 0; j < kRadiusNodes; ++j) {
      // One node before zero, for the interpolation.
      const double radius_px = unit_px * std::sinh(kRadiusStep * std::abs(j - 1));
      disc_table_[static_cast<std::size_t>(i * kRadiusNodes + j)] =
          exact_wing_of_disc(radius_px, disc_px) * unit_px * unit_px;
    }
  }
}

double Psf::wing(double radius_px) const {
  const double q = shape_.wing_exponent, a = shape_.wing_scale_px;
  return (0.5 * q - 1.0) / (kPi * a * a) *
         std::pow(1.0 + radius_px * radius_px / (a * a), -0.5 * q);
}

// Integral over the distance t from the point: circles of radius t lie whole inside the disc up to
// disc - r, and with part of their length from |disc - r| to disc + r.
double Psf::exact_wing_of_disc(double radius_px, double disc_px) const {
  const double a2 = shape_.wing_scale_px * shape_.wing_scale_px;
  const double inner_px = disc_px - radius_px;
  double sum = inner_px > 0.0 ? 1.0 - std::pow(1.0 + inner_px * inner_px / a2,
                                               1.0 - 0.5 * shape_.wing_exponent)
                              : 0.0;
  const double middle_px = std::max(disc_px, radius_px), half_px = std::min(disc_px, radius_px);
  constexpr int kSteps = 64;
  for (int i = 0; i < kSteps && half_px > 0.0; ++i) {
    const double angle_rad = kPi * (i + 0.5) / kSteps;
    const double t_px = middle_px - half_px * std::cos(angle_rad);
    const double cosine =
        (radius_px * radius_px + t_px * t_px - disc_px * disc_px) / (2.0 * radius_px * t_px);
    sum += wing(t_px) * 2.0 * t_px * std::acos(std::clamp(cosine, -1.0, 1.0)) * half_px *
           std::sin(angle_rad) * kPi / kSteps;
  }
  return sum / (kPi * disc_px * disc_px);
}

double Psf::wing_of_disc(double radius_px, double disc_px) const {
  const double unit_px = shape_.wing_scale_px + disc_px;
  const double disc_position =
      std::clamp((std::log(disc_px) - kSmallestDiscLog) / kDiscStep, 1.0, kDiscNodes - 2.001);
  const double radius_position = 1.0 + std::asinh(radius_px / unit_px) / kRadiusStep;
  const auto i = static_cast<std::size_t>(disc_position);
  const auto j = static_cast<std::size_t>(radius_position);
  double rows[4];
  for (std::size_t row = 0; row < 4; ++row)
    rows[row] = cubic(&disc_table_[(i - 1 + row) * kRadiusNodes + j - 1],
                      radius_position - static_cast<double>(j));
  return cubic(rows, disc_position - static_cast<double>(i)) / (unit_px * unit_px);
}

LampProfile Psf::profile(double disc_px) const {
  if (!(disc_px > 0.0 && disc_px <= kLargestDisc_px))
    throw std::domain_error("Psf: disc radius must be above 0 and at most 1000 px");
  const double sigma_px = shape_.core_sigma_px;
  LampProfile lamp;
  lamp.near_radius_px_ = std::max(kSmallestNear_px, kNearPerDisc * disc_px);
  lamp.sharp_radius_px_ = disc_px + kGaussianReach * sigma_px;
  lamp.step_px_ = sigma_px / 6.0;
  lamp.far_table_ = &far_table_;
  lamp.disc_px2_ = disc_px * disc_px;

  // Inside, the far part is the even polynomial that meets it with value, slope and curvature.
  const double edge_px = lamp.near_radius_px_;
  const double q = shape_.wing_exponent;
  const double a2 = shape_.wing_scale_px * shape_.wing_scale_px;
  const double edge2 = edge_px * edge_px;
  const auto far_of = [&](double r2) {
    const double value = shape_.wing_share * wing(std::sqrt(r2));
    return value * (1.0 + lamp.disc_px2_ * q * (q * r2 - 2.0 * a2) / ((a2 + r2) * (a2 + r2)) / 8.0);
  };
  const double h = 1e-3 * edge2;
  const double value = far_of(edge2);
  const double slope = (far_of(edge2 + h) - far_of(edge2 - h)) / (2.0 * h);
  const double curve = (far_of(edge2 + h) - 2.0 * value + far_of(edge2 - h)) / (h * h);
  lamp.extension_[2] = 0.5 * curve;
  lamp.extension_[1] = slope - curve * edge2;
  lamp.extension_[0] = value - slope * edge2 + 0.5 * curve * edge2 * edge2;

  const auto entries = static_cast<std::size_t>(std::ceil(edge_px / lamp.step_px_)) + 4;
  lamp.near_.resize(entries);
  const double flat = (1.0 - shape_.wing_share) / (kPi * disc_px * disc_px);
  for (std::size_t i = 1; i < entries; ++i) {
    const double r_px = static_cast<double>(i - 1) * lamp.step_px_;
    double light = shape_.wing_share > 0.0 ? shape_.wing_share * wing_of_disc(r_px, disc_px) : 0.0;
    if (r_px < disc_px - kGaussianReach * sigma_px)
      light += flat;
    else if (r_px < lamp.sharp_radius_px_)
      light += (1.0 - shape_.wing_share) * gaussian_of_disc(r_px, disc_px, sigma_px);
    const double r2 = r_px * r_px;
    lamp.near_[i] =
        light - (lamp.extension_[0] + r2 * (lamp.extension_[1] + r2 * lamp.extension_[2]));
  }
  lamp.near_[0] = lamp.near_[2];
  return lamp;
}

}  // namespace vildar
