#include "capture/ffmpeg_log.h"

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <string_view>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/log.h>
}

namespace vildar {
namespace {

constexpr std::size_t kLinesKept = 4;
constexpr std::int64_t kPacketsRemembered = 512;  // more than any decoder holds back

std::mutex live_mutex;
std::set<FfmpegLog*> live;

}  // namespace

struct FfmpegLogAccess {
  static void receive(void* context, int level, const char* format, va_list arguments) {
    if (context == nullptr || level > AV_LOG_ERROR) return;
    const AVClass* type = *static_cast<AVClass**>(context);
    if (type == nullptr || type->class_name == nullptr) return;
    const std::string_view name = type->class_name;
    const bool from_demuxer = name == "AVFormatContext";
    if (!from_demuxer && name != "AVCodecContext") return;
    void* opaque = from_demuxer ? static_cast<AVFormatContext*>(context)->opaque
                                : static_cast<AVCodecContext*>(context)->opaque;
    // Contexts of other users of the libraries carry an opaque of their own: only known ones are
    // followed.
    const std::lock_guard lock(live_mutex);
    const auto log = live.find(static_cast<FfmpegLog*>(opaque));
    if (log == live.end()) return;
    std::array<char, 512> text;
    std::vsnprintf(text.data(), text.size(), format, arguments);
    (*log)->note_line(text.data(), from_demuxer);
    if (from_demuxer) return;
    const std::int64_t packet = static_cast<AVCodecContext*>(context)->reordered_opaque;
    if (packet >= 0) (*log)->note_damaged_packet(packet);
  }
};

FfmpegLog::FfmpegLog() {
  const std::lock_guard lock(live_mutex);
  av_log_set_callback(FfmpegLogAccess::receive);
  live.insert(this);
}

FfmpegLog::~FfmpegLog() {
  const std::lock_guard lock(live_mutex);
  live.erase(this);
}

void FfmpegLog::note_line(const std::string& line, bool from_demuxer) {
  std::string trimmed = line;
  while (!trimmed.empty() &&
         (trimmed.back() == '\n' || trimmed.back() == '.' || trimmed.back() == ' '))
    trimmed.pop_back();
  const std::lock_guard lock(mutex_);
  if (from_demuxer) {
    ++demuxer_errors_;
    early_end_ = early_end_ || trimmed.find("partial file") != std::string::npos ||
                 trimmed.find("prematurely") != std::string::npos;
  }
  if (!trimmed.empty() && lines_.size() < kLinesKept &&
      std::find(lines_.begin(), lines_.end(), trimmed) == lines_.end())
    lines_.push_back(trimmed);
}

std::vector<std::string> FfmpegLog::lines() const {
  const std::lock_guard lock(mutex_);
  return lines_;
}

bool FfmpegLog::told_of_early_end() const {
  const std::lock_guard lock(mutex_);
  return early_end_;
}

std::int64_t FfmpegLog::demuxer_errors() const {
  const std::lock_guard lock(mutex_);
  return demuxer_errors_;
}

void FfmpegLog::note_damaged_packet(std::int64_t packet) {
  const std::lock_guard lock(mutex_);
  if (damaged_.insert(packet).second) ++damaged_packets_;
}

std::int64_t FfmpegLog::damaged_packets() const {
  const std::lock_guard lock(mutex_);
  return damaged_packets_;
}

bool FfmpegLog::was_damaged(std::int64_t packet) {
  const std::lock_guard lock(mutex_);
  damaged_.erase(damaged_.begin(), damaged_.lower_bound(packet - kPacketsRemembered));
  return damaged_.contains(packet);
}

}  // namespace vildar
