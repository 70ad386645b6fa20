#include "capture/clip_decoder.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <new>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include "capture/clip_source.h"
#include "capture/row_maxima.h"
#include "core/error.h"

namespace vildar {
namespace {

constexpr int kReadErrorsInARow = 64;
constexpr int kDrainErrors = 1024;

std::string error_text(int error) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(error, text.data(), text.size());
  return text.data();
}

std::string with_lines(std::string fault, const FfmpegLog& log) {
  for (const std::string& line : log.lines()) fault += " (" + line + ")";
  return fault;
}

void check_file(const std::filesystem::path& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status))
    throw InputError(path.string() + ": no such file; check the name and the folder");
  if (std::filesystem::is_directory(status))
    throw InputError(path.string() + ": is a folder; name the clip inside it");
  if (std::filesystem::is_regular_file(status) && std::filesystem::file_size(path, error) == 0 &&
      !error)
    throw InputError(path.string() +
                     ": the file is empty (0 bytes); copy it from the recorder again");
}

bool shows_text(AVCodecID id) {
  return id == AV_CODEC_ID_ANSI || id == AV_CODEC_ID_BINTEXT || id == AV_CODEC_ID_XBIN ||
         id == AV_CODEC_ID_IDF;
}

}  // namespace

void ClipDecoder::Freed::operator()(AVFormatContext* container) const {
  avformat_close_input(&container);
}
void ClipDecoder::Freed::operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
void ClipDecoder::Freed::operator()(AVPacket* packet) const { av_packet_free(&packet); }

ClipDecoder::ClipDecoder(const std::filesystem::path& path, const ClipOptions& options)
    : packet_(av_packet_alloc()) {
  if (packet_ == nullptr) throw std::bad_alloc();
  check_file(path);
  open(path);
  choose_stream(path);
  open_codec(path, options);
}

void ClipDecoder::open(const std::filesystem::path& path) {
  AVFormatContext* container = avformat_alloc_context();
  if (container == nullptr) throw std::bad_alloc();
  container->opaque = &log_;
  AVDictionary* settings = nullptr;
  av_dict_set(&settings, "protocol_whitelist", "file,crypto", 0);
  // "file:" keeps libavformat from taking a name with a colon for a network address.
  const int error =
      avformat_open_input(&container, ("file:" + path.string()).c_str(), nullptr, &settings);
  av_dict_free(&settings);
  container_.reset(container);  // null after a failure
  if (error == AVERROR_INVALIDDATA)
    throw InputError(
        path.string() + with_lines(": is not a video file that can be read", log_) +
        "; check that it was copied whole and is a clip, or recover it with the recorder's tool");
  if (error == AVERROR_EOF)
    throw InputError(path.string() +
                     ": ends before its first frame; check that it was copied whole, or recover "
                     "it with the recorder's tool");
  if (error < 0)
    throw InputError(path.string() + ": cannot be opened: " + error_text(error) +
                     "; check its permissions");
  if (avformat_find_stream_info(container_.get(), nullptr) < 0)
    throw InputError(path.string() + with_lines(": its streams cannot be read", log_) +
                     "; copy it from the recorder again");
}

void ClipDecoder::choose_stream(const std::filesystem::path& path) {
  int sound_streams = 0;
  for (unsigned i = 0; i < container_->nb_streams; ++i) {
    AVStream* stream = container_->streams[i];
    const AVMediaType type = stream->codecpar->codec_type;
    sound_streams += type == AVMEDIA_TYPE_AUDIO ? 1 : 0;
    const bool picture =
        type == AVMEDIA_TYPE_VIDEO && !shows_text(stream->codecpar->codec_id) &&
        (stream->disposition & (AV_DISPOSITION_ATTACHED_PIC | AV_DISPOSITION_STILL_IMAGE)) == 0;
    if (picture && stream_ == nullptr)
      stream_ = stream;
    else
      stream->discard = AVDISCARD_ALL;
  }
  if (stream_ == nullptr)
    throw InputError(path.string() + ": holds no video" +
                     (sound_streams > 0 ? ", only sound" : "") +
                     "; name the clip itself (a photodiode trace goes with --photodiode)");
}

void ClipDecoder::open_codec(const std::filesystem::path& path, const ClipOptions& options) {
  const AVCodecParameters& parameters = *stream_->codecpar;
  const AVCodec* decoder = avcodec_find_decoder(parameters.codec_id);
  if (decoder == nullptr)
    throw InputError(path.string() + ": codec " + avcodec_get_name(parameters.codec_id) +
                     " is not known to the installed libavcodec; convert the clip to H.264");
  codec_.reset(avcodec_alloc_context3(decoder));
  if (codec_ == nullptr || avcodec_parameters_to_context(codec_.get(), &parameters) < 0)
    throw std::bad_alloc();
  codec_->opaque = &log_;
  codec_->reordered_opaque = -1;
  codec_->pkt_timebase = stream_->time_base;
  codec_->thread_count = options.decoder_threads;
  // Exact cropping, and pictures with errors are given rather than swallowed.
  codec_->flags |= AV_CODEC_FLAG_OUTPUT_CORRUPT | AV_CODEC_FLAG_UNALIGNED;
  if (options.skip_loop_filter && parameters.codec_id == AV_CODEC_ID_H264)
    codec_->skip_loop_filter = AVDISCARD_ALL;
  // libavcodec 5.1 tells of the rows of H.264, though not in the decoder's capabilities.
  if (options.decoder_threads == 1 && parameters.codec_id == AV_CODEC_ID_H264)
    note_row_maxima(*codec_);
  if (const int error = avcodec_open2(codec_.get(), decoder, nullptr); error < 0)
    throw InputError(path.string() +
                     with_lines(": its " + std::string(decoder->name) +
                                    " stream cannot be decoded: " + error_text(error),
                                log_) +
                     "; copy it from the recorder again or convert it to H.264");
}

std::optional<DecodedPicture> ClipDecoder::next() {
  int drain_errors = 0;
  for (;;) {
    std::shared_ptr<AVFrame> frame(av_frame_alloc(),
                                   [](AVFrame* released) { av_frame_free(&released); });
    if (frame == nullptr) throw std::bad_alloc();
    const int result = avcodec_receive_frame(codec_.get(), frame.get());
    if (result == AVERROR(ENOMEM)) throw std::bad_alloc();
    if (result == AVERROR_EOF || drain_errors > kDrainErrors) return std::nullopt;
    if (result < 0) {
      if (result != AVERROR(EAGAIN)) log_.note_damaged_packet(codec_->reordered_opaque);
      if (draining_)
        ++drain_errors;
      else
        feed();
      continue;
    }
    DecodedPicture decoded;
    decoded.damaged = (frame->flags & AV_FRAME_FLAG_CORRUPT) != 0 ||
                      frame->decode_error_flags != 0 || log_.was_damaged(frame->reordered_opaque);
    if (frame->best_effort_timestamp != AV_NOPTS_VALUE) {
      constexpr AVRational kNanosecond{1, 1'000'000'000};
      constexpr std::int64_t kFarthest =
          INT64_MAX / 4;  // sums and differences of stamps stay in range
      const std::int64_t stamp_ns =
          av_rescale_q(frame->best_effort_timestamp, stream_->time_base, kNanosecond);
      if (stamp_ns > -kFarthest && stamp_ns < kFarthest)
        decoded.stamp = std::chrono::nanoseconds(stamp_ns);
    }
    decoded.picture = std::move(frame);
    return decoded;
  }
}

/// Hands the decoder one more packet, or the end of the stream.
void ClipDecoder::feed() {
  if (!read_packet()) {
    draining_ = true;
    avcodec_send_packet(codec_.get(), nullptr);
    return;
  }
  codec_->reordered_opaque = packets_read_++;
  if ((packet_->flags & AV_PKT_FLAG_CORRUPT) != 0)
    log_.note_damaged_packet(codec_->reordered_opaque);
  const std::int64_t stamp = packet_->pts != AV_NOPTS_VALUE ? packet_->pts : packet_->dts;
  if (stamp != AV_NOPTS_VALUE) {
    const std::int64_t start = stream_->start_time != AV_NOPTS_VALUE ? stream_->start_time : 0;
    const double end_s =
        static_cast<double>(stamp - start + packet_->duration) * av_q2d(stream_->time_base);
    end_s_ = std::max(end_s_.value_or(end_s), end_s);
  }
  const int result = avcodec_send_packet(codec_.get(), packet_.get());
  av_packet_unref(packet_.get());
  if (result == AVERROR(ENOMEM)) throw std::bad_alloc();
  if (result < 0) log_.note_damaged_packet(codec_->reordered_opaque);
}

/// The next packet of the chosen stream that holds anything; false at the end, also where the file
/// breaks off.
bool ClipDecoder::read_packet() {
  int errors_in_a_row = 0;
  for (;;) {
    const int result = av_read_frame(container_.get(), packet_.get());
    if (result == AVERROR_EOF) {
      broke_off_ = stops_within_a_frame();
      return false;
    }
    if (result < 0) {
      const bool at_end = container_->pb == nullptr || avio_feof(container_->pb) != 0;
      if (at_end || ++errors_in_a_row >= kReadErrorsInARow) {
        broke_off_ = true;
        return false;
      }
      continue;
    }
    errors_in_a_row = 0;
    // An empty packet would tell the decoder that the stream has ended.
    if (packet_->stream_index == stream_->index && packet_->size > 0) {
      packet_end_ = packet_->pos + packet_->size;
      return true;
    }
    av_packet_unref(packet_.get());
  }
}

double ClipDecoder::declared_rate_hz() const {
  const AVRational rate = av_guess_frame_rate(container_.get(), stream_, nullptr);
  return rate.num > 0 && rate.den > 0 ? av_q2d(rate) : 0.0;
}

std::optional<double> ClipDecoder::declared_duration_s() const {
  if (stream_->duration != AV_NOPTS_VALUE && stream_->duration > 0)
    return static_cast<double>(stream_->duration) * av_q2d(stream_->time_base);
  if (container_->duration != AV_NOPTS_VALUE && container_->duration > 0 &&
      container_->duration_estimation_method != AVFMT_DURATION_FROM_BITRATE) {
    // Matroska's runs from stamp 0, wherever the stream starts.
    const bool from_zero = std::strstr(container_->iformat->name, "matroska") != nullptr;
    const std::int64_t before = from_zero && container_->start_time != AV_NOPTS_VALUE &&
                                        container_->start_time < container_->duration
                                    ? container_->start_time
                                    : 0;
    return static_cast<double>(container_->duration - before) / AV_TIME_BASE;
  }
  return std::nullopt;
}

std::int64_t ClipDecoder::damaged_packets() const {
  return log_.damaged_packets() + (truncated() ? 0 : log_.demuxer_errors());
}

bool ClipDecoder::index_points_past_the_end() const {
  const std::int64_t size = container_->pb != nullptr ? avio_size(container_->pb) : -1;
  if (size <= 0) return false;
  const int entries = avformat_index_get_entries_count(stream_);
  for (int i = 0; i < entries; ++i) {
    const AVIndexEntry* entry = avformat_index_get_entry(stream_, i);
    if (entry->pos + entry->size > size) return true;
  }
  return false;
}

/// Of YUV4MPEG, which has neither index nor length; its demuxer passes over part of a frame. One
/// byte more is the newline of an editor.
bool ClipDecoder::stops_within_a_frame() const {
  return std::strcmp(container_->iformat->name, "yuv4mpegpipe") == 0 && container_->pb != nullptr &&
         packet_end_ > 0 && avio_size(container_->pb) > packet_end_ + 1;
}

bool ClipDecoder::truncated() const {
  if (broke_off_ || log_.told_of_early_end() || index_points_past_the_end()) return true;
  // Where other streams may run longer than the picture, only the stream's own duration counts.
  const bool own_duration = container_->nb_streams == 1 || stream_->duration != AV_NOPTS_VALUE;
  const std::optional<double> declared_s = declared_duration_s();
  if (!own_duration || !declared_s || !end_s_ ||
      container_->duration_estimation_method != AVFMT_DURATION_FROM_STREAM)
    return false;
  return *end_s_ < *declared_s - std::max(1.0, 0.02 * *declared_s);
}

}  // namespace vildar
