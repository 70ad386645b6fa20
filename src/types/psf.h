#pragma once

namespace vildar {

/// How lens and cover spread the light of a point: a gaussian core and a power-law wing,
/// (1 - share) gaussian(sigma) + share (q/2 - 1) / (pi a^2) (1 + r^2 / a^2)^(-q/2). Unit flux.
struct PsfShape {
  double core_sigma_px = 0.9;  ///< >= 0.5
  double wing_share = 0.03;    ///< [0, 1)
  double wing_scale_px = 2.0;  ///< a > 0
  double wing_exponent = 2.5;  ///< q > 2

  bool operator==(const PsfShape&) const = default;
};

}  // namespace vildar
