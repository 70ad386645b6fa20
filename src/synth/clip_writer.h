#pragma once

#include <filesystem>
#include <memory>

#include "synth/scenario.h"
#include "types/frame.h"

namespace vildar {

/// clip.mp4 for h264 and h265, clip.mkv for mjpeg and ffv1.
const char* clip_file_name(ClipCodec codec);

/// Encodes pictures to a clip that appears whole under its name, or not at all. The same pictures
/// give the same bytes on the same version of the codec library. Throws OutputError where the clip
/// cannot be written.
class ClipWriter {
 public:
  /// The scenario's site must have a camera.
  ClipWriter(const std::filesystem::path& path, const Scenario& scenario);
  ~ClipWriter();

  /// Frames of the size of the camera, 8 bit, 4:2:0, in order.
  void write(const Frame& frame);
  /// Ends the clip and puts it in place.
  void commit();

 private:
  struct Encoder;
  std::unique_ptr<Encoder> encoder_;
};

}  // namespace vildar
