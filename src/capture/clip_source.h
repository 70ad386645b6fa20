#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "types/frame.h"

namespace vildar {

struct ClipOptions {
  /// Overrides every time stamp: frame k is at k / frame_rate_hz. In (0, 1e6].
  std::optional<double> frame_rate_hz = std::nullopt;
  int decoder_threads = 1;  ///< 1 to 64; with many clips, one thread each is fastest
  /// Faster, and off by at most a few codes; honoured for H.264 only, where the change is below
  /// what the codec itself does to a lamp.
  bool skip_loop_filter = false;
  /// Reads the top field of every picture alone, as of those that say that they are interlaced.
  bool one_field = false;

  /// Every violation, each with field, value and rule.
  std::vector<std::string> problems() const;
};

/// What a clip says of itself, and what its first picture shows.
struct ClipInfo {
  std::filesystem::path path;
  std::string container, codec, pixel_format;
  bool lossless = false;  ///< whatever the codec is told, it loses nothing of a picture
  int width_px = 0;       ///< upright, that is after the turn by rotation_deg
  int height_px = 0;      ///< upright
  int rotation_deg = 0;   ///< clockwise turn that shows the picture upright: 0, 90, 180 or 270
  /// Width of a pixel over its height, upright, as declared; nothing where it is not.
  std::optional<double> pixel_aspect;
  int bit_depth = 8;
  std::string colour_range;  ///< "full" or "limited"; with " (assumed)" where the clip does not say
  double nominal_frame_rate_hz = 0.0;  ///< as declared; 0 where nothing is declared
  std::optional<double> duration_s;    ///< as declared
  std::optional<std::int64_t> frames_declared;
  bool frame_rate_overridden = false;
};

/// What was met on the way; complete once next() has returned nullopt.
struct ClipCounts {
  std::int64_t frames_read = 0;     ///< pictures decoded, those of another size included
  std::int64_t frames_damaged = 0;  ///< of those: the decoder reported errors in them
  /// Of those read: sound by themselves, but between a damaged one and the next key frame, so that
  /// what they show may be predicted from the damage.
  std::int64_t frames_after_damage = 0;
  std::int64_t packets_damaged = 0;
  std::int64_t frames_dropped =
      0;  ///< by the recorder, estimated from gaps in time; 0 at a variable rate
  std::int64_t time_stamps_repaired = 0;
  std::int64_t frames_of_other_size = 0;  ///< left out
  bool truncated = false;                 ///< the file ends before its own index or header says
  std::vector<std::string> warnings;      ///< each names the file, the fault and the remedy

  /// Something in the clip was not as recorded, and what could be read was used.
  bool damaged() const;
};

/// Pictures of a recorded clip in presentation order, any container and codec of libavformat and
/// libavcodec, in constant memory.
///
/// Luma is the decoder's own plane, neither copied nor converted; it stays valid as long as the
/// Frame's owner lives, also after the source is gone. Formats without a plane of luma (RGB,
/// palette, packed YUV) are converted to planar YUV, RGB to full-range BT.709.
///
/// Frame::time is the presentation time less that of the first frame, variable rates kept. A stamp
/// that is missing, repeated (less than 1/200 period after the one before: a muxer's tick) or
/// backward is replaced by one period (the usual one so far; at the start the declared one) after
/// its predecessor, or by the middle between its neighbours where
/// that is sooner. A stamp more than 10 s or 300 periods ahead (whichever is less) counts as wrong
/// unless the next frame carries on from it; one as far behind from which the next frame carries on
/// is a clock that started again, and time goes on without a break. All are counted.
///
/// Damaged packets are survived: the frames they leave, and those after them up to the next key
/// frame, are given with `damaged` set. Frame::index
/// counts every decoded picture, so it has gaps where pictures of another size were left out. One
/// thread at a time may use a source.
class ClipSource {
 public:
  /// Throws InputError, naming file, fault and remedy, where no picture can be read at all, and
  /// std::invalid_argument where the options have problems.
  explicit ClipSource(std::filesystem::path path, ClipOptions options = {});
  ~ClipSource();
  ClipSource(ClipSource&&) noexcept;
  ClipSource& operator=(ClipSource&&) noexcept;

  std::optional<Frame> next();  ///< nullopt: the end of the clip, or of what can be read of it
  const ClipInfo& info() const;
  const ClipCounts& counts() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vildar
