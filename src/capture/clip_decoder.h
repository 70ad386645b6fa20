#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "capture/ffmpeg_log.h"

struct AVCodecContext;
struct AVFormatContext;
struct AVFrame;
struct AVPacket;
struct AVStream;

namespace vildar {

struct ClipOptions;

/// A picture as it left the decoder.
struct DecodedPicture {
  std::shared_ptr<const AVFrame> picture;
  std::optional<std::chrono::nanoseconds> stamp;  ///< presentation time on the clip's own clock
  bool damaged = false;
};

/// Opens the first real video stream of a file and decodes it from start to end, surviving damage.
class ClipDecoder {
 public:
  /// Throws InputError where there is no video stream that can be decoded.
  ClipDecoder(const std::filesystem::path& path, const ClipOptions& options);
  std::optional<DecodedPicture> next();

  const AVFormatContext& container() const { return *container_; }
  const AVStream& stream() const { return *stream_; }
  const FfmpegLog& log() const { return log_; }
  double declared_rate_hz() const;  ///< 0 where nothing is declared
  std::optional<double> declared_duration_s() const;
  std::int64_t packets_read() const { return packets_read_; }
  std::int64_t damaged_packets() const;
  /// Once next() gave nullopt: the file ends before its header, its index or its container's
  /// structure says.
  bool truncated() const;

 private:
  void open(const std::filesystem::path& path);
  void choose_stream(const std::filesystem::path& path);
  void open_codec(const std::filesystem::path& path, const ClipOptions& options);
  void feed();
  bool read_packet();
  bool index_points_past_the_end() const;
  bool stops_within_a_frame() const;

  struct Freed {
    void operator()(AVFormatContext* container) const;
    void operator()(AVCodecContext* codec) const;
    void operator()(AVPacket* packet) const;
  };

  FfmpegLog log_;  // first, so that it outlives the contexts that report to it
  std::unique_ptr<AVFormatContext, Freed> container_;
  AVStream* stream_ = nullptr;  ///< owned by container_
  std::unique_ptr<AVCodecContext, Freed> codec_;
  std::unique_ptr<AVPacket, Freed> packet_;
  std::int64_t packets_read_ = 0;
  std::optional<double> end_s_;  ///< of the last packet, from the start of the stream
  bool draining_ = false;
  bool broke_off_ = false;
  std::int64_t packet_end_ = 0;  ///< where in the file the last packet ends
};

}  // namespace vildar
