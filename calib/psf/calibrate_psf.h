#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "calib/psf/lamp_crops.h"
#include "core/outcome.h"
#include "types/site.h"

namespace vildar {

/// A camera's PSF from pictures of its lamps, and how well it is known.
struct PsfCalibration {
  PsfSite psf;
  double core_sigma_std_px = 0.0, wing_scale_std_px = 0.0, wing_exponent_std = 0.0;
  /// Keys of `camera.psf` of which the lamps tell little more than was thought before.
  std::vector<std::string> undetermined;
  int crops = 0, lamps = 0, frames = 0;  ///< that the PSF rests on
  std::map<std::string, int> left_out;   ///< crops, by reason
  /// Lamps by how many times nominal white the light of their middle is: below 1, 10, 100, 1000,
  /// and more.
  std::array<int, 5> by_brightness{};
  double chi2_per_dof = 0.0;              ///< median over crops, with the pixels' noise alone
  double shaped_share = 0.0;              ///< of crops: the residuals have a shape
  bool wings_from_clipped_alone = false;  ///< no lamp clips so little that its core is seen
};

/// Finds the PSF that explains all crops: flux, place and radius of each lamp and a background for
/// each crop are free. Crops whose residuals have a shape under the PSF found (lit road, a
/// reflection, no uniform disc) are left out, unless `lossy` (a clip was coded with loss): then
/// nearly all have, each weighs by its own scatter, and the sigmas hold what coding does to all
/// alike. Misses: too_few_samples (fewer than eight crops), not_converged, unobservable (the share
/// of the wings), bad_fit (no PSF of this form explains more than a quarter of the crops).
Outcome<PsfCalibration> calibrate_psf(std::span<const LampCrop> crops, bool lossy);

}  // namespace vildar
