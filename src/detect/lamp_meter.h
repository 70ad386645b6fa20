#pragma once

#include <optional>
#include <vector>

#include "detect/lamp_fit.h"
#include "detect/photometry.h"
#include "types/site.h"

namespace vildar {

/// Radius of a light's clipped area; 0 where nothing clips.
double rim_px(const Peak& peak);

/// Measures the lamps of one frame after the other by fits of a calibrated point-spread function,
/// lamps that overlap together, beside the wings of the others. Remembers the last frame: how large
/// and how bright a lamp was, and how far it has moved since, which says how long a way it is drawn
/// out to within the exposure.
class LampMeter {
 public:
  LampMeter(const PsfSite& psf, std::optional<double> exposure_s);

  /// Puts what the fits find into the lights of lamps. A light whose residuals have a shape that no
  /// background explains, or for which no fit is found, is marked and keeps its plain measures.
  /// `coded`, of pictures coded with loss alone: the same frame, as lamps that clip are told their
  /// light from, where `light` tells their places.
  void measure(const FrameLight& light, const FrameLight* coded, CameraTime time,
               const std::vector<Peak>& peaks, std::vector<Measured>& lights);

 private:
  struct Known {
    OtherLamp lamp;
    double background = 0.0;             ///< where it was fitted
    int first_attempt = 0, attempt = 0;  ///< at the background; see LampFitter
    int looks = 0;                       ///< since it was last fitted from the start
    bool fitted = false;
  };
  void start(const FrameLight& light, std::size_t k, const Peak& peak, const Measured& seen,
             double since_s);
  bool fit_group(const FrameLight& light, const FrameLight* coded, std::size_t group,
                 std::vector<Measured>& lights);
  void find_groups(const std::vector<Peak>& peaks, const std::vector<Measured>& lights);

  LampFitter fitter_;
  double core_sigma_px_;
  std::optional<double> exposure_s_;
  std::vector<Known> before_, now_;
  std::optional<CameraTime> before_at_;
  std::vector<std::size_t> lamps_;     // indices of lights that are to be fitted
  std::vector<std::size_t> group_of_;  // of each of them
  std::vector<double> nearest_px_;     // distance from each of them to the next
  std::vector<LampGuess> starts_;      // of each of them
  int fits_ = 0;                       // of groups, in this frame
  std::vector<int> fitted_by_;         // of each group: which of them was its last; 0: none was
  std::vector<int> changed_by_;        // of each lamp: which of them last changed its light much
  std::vector<std::size_t> members_;
  std::vector<LampGuess> guesses_;
  std::vector<OtherLamp> others_;
};

}  // namespace vildar
