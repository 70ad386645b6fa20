#pragma once

#include <vector>

#include "types/psf.h"

namespace vildar {

/// The image of a uniform disc through a PSF, as a function of the distance from its centre. It
/// comes in two parts whose sum is exact: `near`, which is zero from `near_radius_px` on, and the
/// smooth `far`, which a coarse grid holds well.
class LampProfile {
 public:
  /// Light per pixel area and unit flux.
  double near(double radius_px) const;
  double near_radius_px() const { return near_radius_px_; }
  /// Within this radius light changes quickly over one pixel.
  double sharp_radius_px() const { return sharp_radius_px_; }
  double far(double radius_px) const;

 private:
  friend class Psf;
  double near_radius_px_ = 0.0;
  double sharp_radius_px_ = 0.0;
  double step_px_ = 1.0;
  std::vector<double> near_;  ///< at (i - 1) * step, two beyond the end
  const std::vector<double>* far_table_ = nullptr;
  double disc_px2_ = 0.0;
  double extension_[3] = {0.0, 0.0, 0.0};  ///< of far() inside: c0 + c1 r^2 + c2 r^4
};

/// Radius of the largest disc that a lamp profile is made of.
inline constexpr double kLargestDisc_px = 1000.0;

/// Makes lamp profiles; the slow part is done once. Thread-safe after construction.
class Psf {
 public:
  /// `reach_px`: the largest distance that LampProfile::far will be asked for.
  /// Throws std::invalid_argument outside the ranges of PsfShape.
  Psf(const PsfShape& shape, double reach_px);

  /// `disc_radius_px` in (0, kLargestDisc_px]; throws std::domain_error outside. Valid while this
  /// Psf lives.
  LampProfile profile(double disc_radius_px) const;
  const PsfShape& shape() const { return shape_; }
  /// Wing of a point source, without its share.
  double wing(double radius_px) const;

 private:
  double exact_wing_of_disc(double radius_px, double disc_radius_px) const;
  double wing_of_disc(double radius_px, double disc_radius_px) const;

  PsfShape shape_;
  std::vector<double> far_table_;   ///< per pixel of radius: wing, its Laplacian / 8
  std::vector<double> disc_table_;  ///< wing of discs, by disc radius and radius
};

}  // namespace vildar
