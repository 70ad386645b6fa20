#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "synth/light_plane.h"

namespace vildar {

/// A core of 0.9 px and wings.
inline const PsfShape kGlare{0.9, 0.03, 2.0, 2.5};

/// Square pictures of lamps, row by row in the unit of the lamps' flux: the profiles of the
/// renderer integrated over each pixel, three Gauss points a side, and along the lamp's way.
class LampPictures {
 public:
  LampPictures(const PsfShape& shape, int size_px)
      : size_px_(size_px), psf_(shape, 4.0 * size_px) {}

  /// Lamps move by their velocity times a second.
  std::vector<double> of(const std::vector<LampImage>& lamps) const {
    std::vector<double> light(static_cast<std::size_t>(size_px_ * size_px_), 0.0);
    for (const LampImage& lamp : lamps) {
      const LampProfile profile = psf_.profile(lamp.disc_radius_px);
      const int steps = lamp.velocity_px_per_s.norm() > 0.0 ? 24 : 1;
      for (int step = 0; step < steps; ++step) {
        const Eigen::Vector2d centre_px =
            lamp.centre_px + ((step + 0.5) / steps - 0.5) * lamp.velocity_px_per_s;
        for (std::size_t i = 0; i < light.size(); ++i) {
          const int u = static_cast<int>(i) % size_px_, v = static_cast<int>(i) / size_px_;
          light[i] += lamp.flux / steps * on_pixel(profile, u - centre_px.x(), v - centre_px.y());
        }
      }
    }
    return light;
  }

  /// Flux, in units of one pixel at nominal white, of a lamp whose middle would shine
  /// `times_white`.
  double flux(double disc_px, double times_white) const {
    const LampProfile profile = psf_.profile(disc_px);
    return times_white / (profile.near(0.0) + profile.far(0.0));
  }

  static LampImage lamp(double u, double v, double disc_px, double flux) {
    LampImage image;
    image.centre_px = {u, v};
    image.disc_radius_px = disc_px;
    image.flux = flux;
    return image;
  }

 private:
  static double on_pixel(const LampProfile& profile, double du_px, double dv_px) {
    constexpr double kNode = 0.3872983346207417;  // sqrt(3/5) / 2
    constexpr double kPlaces[3] = {-kNode, 0.0, kNode};
    constexpr double kWeights[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
    double sum = 0.0;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const double r_px = std::hypot(du_px + kPlaces[i], dv_px + kPlaces[j]);
        sum += kWeights[i] * kWeights[j] * (profile.near(r_px) + profile.far(r_px));
      }
    return sum;
  }

  int size_px_;
  Psf psf_;
};

}  // namespace vildar
