#pragma once

#include <cstdint>
#include <mutex>
#include <set>
#include <string>
#include <vector>

namespace vildar {

/// Collects what libavformat and libavcodec have to say about one clip. The first one made takes
/// over the log of the whole process, so that the libraries never print.
///
/// Set as `opaque` of the AVFormatContext and AVCodecContext; those must be gone before it is.
/// Thread-safe.
class FfmpegLog {
 public:
  FfmpegLog();
  ~FfmpegLog();
  FfmpegLog(const FfmpegLog&) = delete;
  FfmpegLog& operator=(const FfmpegLog&) = delete;

  /// The first few messages at error level, in order, each once.
  std::vector<std::string> lines() const;
  /// Messages of the demuxer that speak of a file that ends too early.
  bool told_of_early_end() const;
  std::int64_t demuxer_errors() const;

  /// Something is wrong with this packet (numbered by AVCodecContext::reordered_opaque).
  void note_damaged_packet(std::int64_t packet);
  std::int64_t damaged_packets() const;
  /// Whether the packet a picture came from was damaged; packets far before it are forgotten.
  bool was_damaged(std::int64_t packet);

 private:
  friend struct FfmpegLogAccess;
  void note_line(const std::string& line, bool from_demuxer);

  mutable std::mutex mutex_;
  std::vector<std::string> lines_;
  std::set<std::int64_t> damaged_;
  std::int64_t damaged_packets_ = 0;
  std::int64_t demuxer_errors_ = 0;
  bool early_end_ = false;
};

}  // namespace vildar
