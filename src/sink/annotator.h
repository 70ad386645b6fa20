#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/atomic_file.h"
#include "types/blob.h"
#include "types/frame.h"
#include "types/vehicle_track.h"

namespace vildar {

/// What is drawn of one vehicle in one frame; places are in the upright image.
struct AnnotationBox {
  int track_id = 0;
  Direction direction = Direction::oncoming;
  std::optional<PixelBox> left, right;    ///< lamp outlines
  std::string label;                      ///< ASCII, `+-` (or the sign itself) is drawn as a sign
  std::vector<Eigen::Vector2d> trail_px;  ///< past places, oldest first
};

struct AnnotatorOptions {
  /// Encoders of libavcodec, the first one present is used.
  std::vector<std::string> encoders{"libx264", "mpeg4"};
};

/// annotated.mp4: the clip upright with lamps, vehicles, speeds and trails drawn in. The picture is
/// enlarged by a whole factor until it is at least 720 px high, and padded to even sides. Frames
/// keep their presentation times to 1/60000 s. The index stands at the front of the file. One
/// thread at a time.
class Annotator {
 public:
  /// Size of the upright picture in pixels, both > 0. Throws OutputError where the file cannot be
  /// written or no encoder is there.
  Annotator(const std::filesystem::path& path, int width_px, int height_px,
            double nominal_frame_rate_hz, const AnnotatorOptions& options = {});
  ~Annotator();
  Annotator(const Annotator&) = delete;
  Annotator& operator=(const Annotator&) = delete;

  /// Frames in presentation order; one whose time does not increase is shown 1/60000 s after the
  /// last. A frame of another size is scaled to fit.
  void add(const Frame& frame, std::span<const AnnotationBox> boxes);
  /// The file, finished and not yet committed; nothing may be added after it.
  [[nodiscard]] AtomicFile finish();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace vildar
