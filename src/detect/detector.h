#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "detect/lamp_fit.h"
#include "detect/photometry.h"
#include "optics/response.h"
#include "types/blob.h"
#include "types/frame.h"

namespace vildar {

/// What counts as a light. The defaults hold for street-lit and dark scenes alike; the threshold
/// follows each frame's background and noise.
struct DetectOptions {
  double threshold_sigma = 8.0;      ///< above the frame's background, in noise sigmas; > 0
  double threshold_fraction = 0.08;  ///< least threshold, share of black..white above black; (0, 1)
  /// The threshold rises until at most this share of the frame is brighter; (0, 1].
  double max_bright_share = 0.03;
  int min_area_px = 2;  ///< pixels above the threshold; >= 1
  /// Depth of the valley that makes two peaks two lights, share of black..white; (0, 1).
  double min_valley_fraction = 0.05;
  /// Electrons of a pixel at nominal white, for photon noise; > 0.
  double full_well_electrons = 20000.0;
  bool lossy = false;  ///< the pictures were coded with loss, which lamp fits then account for

  /// Every violation, each with field, value and rule; empty when all hold.
  std::vector<std::string> problems() const;
};

/// A frame's lights before lamps are fitted, in stored pixels; valid until the detector's next
/// frame.
struct SeenLights {
  FrameLight light;
  std::span<const Peak> peaks;
  std::span<const Measured> lights;  ///< of each peak
};

/// Finds the lights of one frame at a time. Keeps its buffers, and what it learned of the code at
/// which the camera clips, from frame to frame; frames of one camera per detector, one thread at a
/// time.
class Detector {
 public:
  /// `exposure_s`, where known, divides fluxes. With `psf` lamps are fitted, those that clip as
  /// well; without it their light is a lower bound. Throws std::invalid_argument listing
  /// `options.problems()`, when an exposure is not positive, or as DiscImage does.
  Detector(DetectOptions options, Response response, std::optional<double> exposure_s,
           const std::optional<PsfSite>& psf = std::nullopt);
  ~Detector();
  Detector(Detector&&) noexcept;
  Detector& operator=(Detector&&) noexcept;

  /// Blobs in reading order of their boxes as stored. An empty plane, or one as bright all over as
  /// its lights, has none. Throws std::invalid_argument for a plane that is not 8 to 16 bits deep,
  /// whose white is not above its black, or a rotation that is not a multiple of 90.
  BlobFrame detect(const Frame& frame);

  /// The same lights as they are before lamps are fitted; nothing where there are none.
  std::optional<SeenLights> look(const Frame& frame);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace vildar
