#include "synth/clip_writer.h"

#include <cmath>
#include <cstring>
#include <string>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
}

#include "core/atomic_file.h"
#include "core/error.h"
#include "synth/frame_times.h"

namespace vildar {
namespace {

struct ContextDeleter {
  void operator()(AVCodecContext* context) const { avcodec_free_context(&context); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
  void operator()(AVFormatContext* format) const {
    if (format->pb) avio_closep(&format->pb);
    avformat_free_context(format);
  }
};

AVColorTransferCharacteristic transfer_of(ResponseKind kind) {
  switch (kind) {
    case ResponseKind::linear: return AVCOL_TRC_LINEAR;
    case ResponseKind::srgb: return AVCOL_TRC_IEC61966_2_1;
    case ResponseKind::bt709: return AVCOL_TRC_BT709;
    case ResponseKind::gamma:
    case ResponseKind::table: return AVCOL_TRC_UNSPECIFIED;
  }
  return AVCOL_TRC_UNSPECIFIED;
}

const char* encoder_name(ClipCodec codec) {
  switch (codec) {
    case ClipCodec::h264: return "libx264";
    case ClipCodec::h265: return "libx265";
    case ClipCodec::mjpeg: return "mjpeg";
    case ClipCodec::ffv1: return "ffv1";
  }
  return "";
}

bool is_mp4(ClipCodec codec) { return codec == ClipCodec::h264 || codec == ClipCodec::h265; }

void apply_quality(const EncoderScene& settings, AVCodecContext& context) {
  const std::string crf = std::to_string(settings.crf);
  switch (settings.codec) {
    case ClipCodec::ffv1: context.level = 3; return;
    case ClipCodec::mjpeg:
      context.strict_std_compliance = FF_COMPLIANCE_UNOFFICIAL;  // limited range
      context.flags |= AV_CODEC_FLAG_QSCALE;
      context.global_quality = settings.quality * FF_QP2LAMBDA;
      return;
    case ClipCodec::h264:
      av_opt_set(context.priv_data, "preset", "medium", 0);
      // With it x264 reads memory that it never wrote, and the same pictures give other bytes.
      av_opt_set(context.priv_data, "mbtree", "0", 0);
      break;
    case ClipCodec::h265:
      av_opt_set(context.priv_data, "preset", "medium", 0);
      av_opt_set(context.priv_data, "x265-params", "log-level=none:pools=none:frame-threads=1", 0);
      context.codec_tag = MKTAG('h', 'v', 'c', '1');
      break;
  }
  if (settings.bitrate_bps)
    context.bit_rate = *settings.bitrate_bps;
  else
    av_opt_set(context.priv_data, "crf", crf.c_str(), 0);
}

}  // namespace

const char* clip_file_name(ClipCodec codec) { return is_mp4(codec) ? "clip.mp4" : "clip.mkv"; }

struct ClipWriter::Encoder {
  explicit Encoder(const std::filesystem::path& path) : file(path) {}

  [[noreturn]] void fail(const std::string& what, int code) const {
    char reason[AV_ERROR_MAX_STRING_SIZE];
    av_strerror(code, reason, sizeof reason);
    throw OutputError(file.path().string() + ": " + what + ": " + reason +
                      "; check the encoder settings and the space left on the disk");
  }
  void check(int code, const char* what) const {
    if (code < 0) fail(what, code);
  }
  void drain() const {
    for (;;) {
      const int code = avcodec_receive_packet(context.get(), packet.get());
      if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) return;
      check(code, "encoding failed");
      av_packet_rescale_ts(packet.get(), context->time_base, stream->time_base);
      packet->stream_index = stream->index;
      check(av_interleaved_write_frame(format.get(), packet.get()), "writing the clip failed");
    }
  }

  AtomicFile file;
  std::unique_ptr<AVFormatContext, ContextDeleter> format;
  std::unique_ptr<AVCodecContext, ContextDeleter> context;
  std::unique_ptr<AVFrame, ContextDeleter> picture;
  std::unique_ptr<AVPacket, ContextDeleter> packet;
  AVStream* stream = nullptr;
  bool uneven = false;
  std::int64_t next_pts = 0;
};

ClipWriter::ClipWriter(const std::filesystem::path& path, const Scenario& scenario)
    : encoder_(std::make_unique<Encoder>(path)) {
  av_log_set_level(AV_LOG_QUIET);  // a library never prints; return codes say what failed
  Encoder& e = *encoder_;
  const EncoderScene& settings = scenario.encoder;
  const CameraSite& camera = *scenario.site.camera;
  const bool in_mp4 = is_mp4(settings.codec);
  e.uneven = frames_uneven(scenario);
  const AVCodec* codec = avcodec_find_encoder_by_name(encoder_name(settings.codec));
  if (!codec)
    throw OutputError(path.string() + ": this libavcodec has no encoder " +
                      encoder_name(settings.codec) + "; install one that has");
  e.context.reset(avcodec_alloc_context3(codec));
  e.picture.reset(av_frame_alloc());
  e.packet.reset(av_packet_alloc());
  if (!e.context || !e.picture || !e.packet) e.fail("no memory for the encoder", AVERROR(ENOMEM));
  AVCodecContext& c = *e.context;
  c.width = camera.width_px;
  c.height = camera.height_px;
  c.pix_fmt = AV_PIX_FMT_YUV420P;
  c.framerate = av_d2q(scenario.frame_rate_hz, 100100);
  c.time_base = e.uneven ? AVRational{1, kUnevenTicks_hz} : av_inv_q(c.framerate);
  c.color_range = AVCOL_RANGE_MPEG;
  c.colorspace = AVCOL_SPC_BT709;
  c.color_primaries = AVCOL_PRI_BT709;
  c.color_trc = transfer_of(camera.response);
  c.gop_size = static_cast<int>(std::lround(2.0 * scenario.frame_rate_hz)) + 1;
  c.thread_count = 1;  // the bytes depend on how many threads share the work
  c.flags |= AV_CODEC_FLAG_BITEXACT;
  apply_quality(settings, c);

  AVFormatContext* format = nullptr;
  const std::string part = e.file.part_path().string();
  e.check(
      avformat_alloc_output_context2(&format, nullptr, in_mp4 ? "mp4" : "matroska", part.c_str()),
      "no such container");
  e.format.reset(format);
  format->flags |= AVFMT_FLAG_BITEXACT;
  if (format->oformat->flags & AVFMT_GLOBALHEADER) c.flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  e.check(avcodec_open2(&c, codec, nullptr), "the encoder does not start");
  e.stream = avformat_new_stream(format, nullptr);
  if (!e.stream) e.fail("no stream", AVERROR(ENOMEM));
  e.stream->time_base = c.time_base;
  e.stream->avg_frame_rate = c.framerate;
  e.check(avcodec_parameters_from_context(e.stream->codecpar, &c), "no stream parameters");
  e.check(avio_open(&format->pb, part.c_str(), AVIO_FLAG_WRITE), "cannot be opened");
  AVDictionary* options = nullptr;
  if (in_mp4) av_dict_set(&options, "movflags", "+faststart", 0);
  const int code = avformat_write_header(format, &options);
  av_dict_free(&options);
  e.check(code, "the header cannot be written");

  e.picture->format = c.pix_fmt;
  e.picture->width = c.width;
  e.picture->height = c.height;
  e.check(av_frame_get_buffer(e.picture.get(), 0), "no memory for a picture");
}

ClipWriter::~ClipWriter() = default;

void ClipWriter::write(const Frame& frame) {
  Encoder& e = *encoder_;
  AVFrame& picture = *e.picture;
  e.check(av_frame_make_writable(&picture), "no memory for a picture");
  for (int v = 0; v < picture.height; ++v)
    std::memcpy(picture.data[0] + v * picture.linesize[0], frame.luma.row(v),
                static_cast<std::size_t>(picture.width));
  const int chroma_width = (picture.width + 1) / 2;
  for (int v = 0; v < (picture.height + 1) / 2; ++v) {
    const std::ptrdiff_t offset = v * frame.chroma.stride_bytes;
    std::memcpy(picture.data[1] + v * picture.linesize[1], frame.chroma.cb + offset,
                static_cast<std::size_t>(chroma_width));
    std::memcpy(picture.data[2] + v * picture.linesize[2], frame.chroma.cr + offset,
                static_cast<std::size_t>(chroma_width));
  }
  picture.pts = e.uneven ? std::llround(seconds_of(frame.time) * kUnevenTicks_hz) : e.next_pts++;
  e.check(avcodec_send_frame(e.context.get(), &picture), "encoding failed");
  e.drain();
}

void ClipWriter::commit() {
  Encoder& e = *encoder_;
  e.check(avcodec_send_frame(e.context.get(), nullptr), "encoding failed");
  e.drain();
  e.check(av_write_trailer(e.format.get()), "the clip cannot be finished");
  e.check(avio_closep(&e.format->pb), "the clip cannot be finished");
  e.file.commit();
}

}  // namespace vildar
