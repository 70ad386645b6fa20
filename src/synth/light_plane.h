#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "synth/light.h"
#include "synth/psf.h"

namespace vildar {

/// How one lamp falls on the sensor during one exposure.
struct LampImage {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  ///< at the middle of its own row's exposure
  Eigen::Vector2d velocity_px_per_s = Eigen::Vector2d::Zero();
  double disc_radius_px = 0.0;
  double flux = 0.0;  ///< electrons over the whole picture of the lamp
  LightColour colour;
  double streak_px = 0.0;  ///< > 0: a mirror image, gaussian upright, without wings
};

/// A lit quadrangle, corners in order round it; its edges are softened by the core of the PSF.
struct QuadImage {
  std::array<Eigen::Vector2d, 4> corners_px;
  double light = 0.0;  ///< electrons per pixel
  LightColour colour;
};

/// Sums the light of lamps over a picture, linear, in electrons; what lies outside is lost.
/// Not thread-safe.
class LightPlane {
 public:
  /// `exposure_s` smears moving lamps; `row_s` is the time from one row to the next.
  LightPlane(int width_px, int height_px, const Psf& psf, double exposure_s, double row_s);

  void add(const LampImage& lamp);
  void add(const QuadImage& quad);
  void clear();

  /// Columns [first, last) of a row that hold more than the smooth far light; empty where first >=
  /// last.
  struct Span {
    int first = 0, last = 0;
  };
  Span touched(int v) const { return spans_[static_cast<std::size_t>(v)]; }
  const float* near_row(int v) const { return &luminance_[offset(v)]; }
  const float* red_row(int v) const { return &red_[offset(v)]; }
  const float* blue_row(int v) const { return &blue_[offset(v)]; }
  /// The far light of a row, `width` values.
  void far_row(int v, float* light) const;
  bool has_far() const { return has_far_; }

  /// All light of one pixel.
  double at(int u, int v) const;

 private:
  /// Notes that columns [first, last] of a row are about to be written.
  void touch(int v, int first, int last);
  std::size_t offset(int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_px_);
  }
  void add_near(const LampImage& lamp, const LampProfile& profile, double time_s, double share);
  void add_streak(const LampImage& lamp);
  void add_far(const LampImage& lamp, const LampProfile& profile);

  int width_px_, height_px_;
  const Psf* psf_;
  double exposure_s_, row_s_;
  std::vector<float> luminance_, red_, blue_;
  std::vector<Span> spans_;
  std::vector<float> streak_weights_;
  int far_columns_, far_rows_;
  std::vector<float> far_;
  bool has_far_ = false;
};

}  // namespace vildar
