#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include <opencv2/core.hpp>

namespace vildar {

/// Ticks per second of the time stamps that the encoder takes: exact for the usual frame rates,
/// 1001 ones included, and small enough for MPEG-4 part 2.
inline constexpr int kVideoTicksHz = 60000;

struct VideoFormat {
  int width_px = 0;   ///< even
  int height_px = 0;  ///< even
  double nominal_frame_rate_hz = 0.0;
};

/// Encodes BGR pictures into an MP4 file with its index at the front. Every failure throws
/// OutputError with `shown_name` in its message.
class VideoEncoder {
 public:
  /// Writes to `file`; the first of `encoders` that this libavcodec has is used.
  VideoEncoder(const std::string& file, const std::string& shown_name, const VideoFormat& format,
               std::span<const std::string> encoders);
  ~VideoEncoder();
  VideoEncoder(const VideoEncoder&) = delete;
  VideoEncoder& operator=(const VideoEncoder&) = delete;

  /// `picture` is 8-bit BGR of the format's size; `ticks` increase strictly.
  void add(const cv::Mat& picture, std::int64_t ticks);
  /// Flushes the encoder and writes the index; nothing may be added after.
  void finish();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace vildar
