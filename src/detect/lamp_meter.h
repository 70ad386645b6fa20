#pragma once

#include <optional>
#include <vector>

#include "detect/lamp_fit.h"
#include "detect/photometry.h"
#include "types/site.h"

namespace vildar {

/// Measures the lamps of one frame after the other by fits of a calibrated point-spread function,
/// lamps that overlap together. Remembers the last frame: how large a lamp's disc was, and how far
/// it has moved since, which says how long a way it is drawn out to within the exposure.
class LampMeter {
 public:
  LampMeter(const PsfSite& psf, std::optional<double> exposure_s);

  /// Puts what the fits find into the lights of lamps. Where the residuals of a fit have a shape
  /// the light is marked: its flux has a sigma that is wider for it, and its centre stays as it
  /// was. So is one for which no fit is found, or none that tells more than a factor.
  void measure(const FrameLight& light, CameraTime time, const std::vector<Peak>& peaks,
               std::vector<Measured>& lights);

 private:
  struct Known {
    Eigen::Vector2d centre_px;
    double radius_px;
    int looks;  ///< since it was last fitted from the start
  };
  LampGuess guess_of(const Peak& peak, const Measured& light, double nearest_px, double since_s);
  void find_groups(const std::vector<Peak>& peaks, const std::vector<Measured>& lights);

  LampFitter fitter_;
  double core_sigma_px_;
  std::optional<double> exposure_s_;
  std::vector<Known> before_, now_;
  std::optional<CameraTime> before_at_;
  std::vector<std::size_t> lamps_;     // indices of lights that are to be fitted
  std::vector<std::size_t> group_of_;  // of each of them
  std::vector<double> nearest_px_;     // distance from each of them to the next
  std::vector<LampGuess> guesses_;
  std::vector<int> looks_;  // of each guess
};

}  // namespace vildar
