#include "sink/video_encoder.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include <array>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include "core/error.h"

namespace vildar {
namespace {

constexpr int kEncoderThreads = 2;
// Sparks of light on black compress well; 23 keeps thin text sharp.
constexpr const char* kQuality = "23";
// Encoders talk on standard error at levels up to debug; a library does not.
constexpr int kSilenceEncoder = AV_LOG_TRACE;

struct FreeContext {
  void operator()(AVCodecContext* context) const { avcodec_free_context(&context); }
};
struct FreeFrame {
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
};
struct FreePacket {
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};
struct FreeScaler {
  void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
};
struct FreeMuxer {
  void operator()(AVFormatContext* muxer) const {
    avio_closep(&muxer->pb);
    avformat_free_context(muxer);
  }
};

std::string error_text(int error) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> buffer{};
  av_strerror(error, buffer.data(), buffer.size());
  return buffer.data();
}

const AVCodec* first_present(std::span<const std::string> encoders) {
  for (const std::string& name : encoders)
    if (const AVCodec* codec = avcodec_find_encoder_by_name(name.c_str())) return codec;
  return nullptr;
}

}  // namespace

struct VideoEncoder::Parts {
  std::string shown_name;
  std::unique_ptr<AVFormatContext, FreeMuxer> muxer;
  std::unique_ptr<AVCodecContext, FreeContext> encoder;
  std::unique_ptr<AVFrame, FreeFrame> frame;
  std::unique_ptr<AVPacket, FreePacket> packet;
  std::unique_ptr<SwsContext, FreeScaler> scaler;
  AVStream* stream = nullptr;
  std::int64_t frame_ticks = 0;

  [[noreturn]] void fail(std::string_view what, const std::string& why) const {
    throw OutputError(shown_name + ": " + std::string(what) + ": " + why +
                      "; choose a folder with space left, or leave the annotated clip out");
  }
  void check(int result, std::string_view what) const {
    if (result < 0) fail(what, error_text(result));
  }
  void open_encoder(const AVCodec* codec, const VideoFormat& format);
  void open_file(const std::string& file);
  void open_scaler();
  void encode(const AVFrame* picture);
};

void VideoEncoder::Parts::open_encoder(const AVCodec* codec, const VideoFormat& format) {
  encoder.reset(avcodec_alloc_context3(codec));
  if (!encoder) throw std::bad_alloc();
  encoder->log_level_offset = kSilenceEncoder;
  encoder->width = format.width_px;
  encoder->height = format.height_px;
  encoder->pix_fmt = AV_PIX_FMT_YUV420P;
  encoder->time_base = {1, kVideoTicksHz};
  encoder->framerate = av_d2q(format.nominal_frame_rate_hz, 100000);
  encoder->sample_aspect_ratio = {1, 1};
  encoder->color_range = AVCOL_RANGE_MPEG;
  encoder->colorspace = AVCOL_SPC_BT709;
  encoder->color_primaries = AVCOL_PRI_BT709;
  encoder->color_trc = AVCOL_TRC_BT709;
  encoder->thread_count = kEncoderThreads;
  // Without reordering the stored times are the presentation times: no edit list to get wrong.
  encoder->max_b_frames = 0;
  encoder->gop_size = std::max(12, static_cast<int>(2.0 * format.nominal_frame_rate_hz));
  if (muxer->oformat->flags & AVFMT_GLOBALHEADER) encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  if (std::string_view(codec->name) == "libx264") {
    check(av_opt_set(encoder->priv_data, "preset", "veryfast", 0), "preset");
    check(av_opt_set(encoder->priv_data, "crf", kQuality, 0), "quality");
  } else {
    encoder->flags |= AV_CODEC_FLAG_QSCALE;
    encoder->global_quality = 4 * FF_QP2LAMBDA;
  }
  check(avcodec_open2(encoder.get(), codec, nullptr), "the encoder does not start");
}

void VideoEncoder::Parts::open_file(const std::string& file) {
  stream = avformat_new_stream(muxer.get(), nullptr);
  if (stream == nullptr) throw std::bad_alloc();
  check(avcodec_parameters_from_context(stream->codecpar, encoder.get()), "stream");
  stream->time_base = encoder->time_base;
  stream->avg_frame_rate = encoder->framerate;
  check(avio_open(&muxer->pb, file.c_str(), AVIO_FLAG_WRITE), "cannot be opened");
  AVDictionary* options = nullptr;
  av_dict_set(&options, "movflags", "+faststart", 0);
  const int result = avformat_write_header(muxer.get(), &options);
  av_dict_free(&options);
  check(result, "header cannot be written");
}

void VideoEncoder::Parts::open_scaler() {
  scaler.reset(sws_getContext(encoder->width, encoder->height, AV_PIX_FMT_BGR24, encoder->width,
                              encoder->height, AV_PIX_FMT_YUV420P, SWS_BILINEAR | SWS_ACCURATE_RND,
                              nullptr, nullptr, nullptr));
  if (!scaler) throw std::bad_alloc();
  const int* matrix = sws_getCoefficients(SWS_CS_ITU709);
  sws_setColorspaceDetails(scaler.get(), matrix, 1, matrix, 0, 0, 1 << 16, 1 << 16);
  frame.reset(av_frame_alloc());
  packet.reset(av_packet_alloc());
  if (!frame || !packet) throw std::bad_alloc();
  frame->format = encoder->pix_fmt;
  frame->width = encoder->width;
  frame->height = encoder->height;
  check(av_frame_get_buffer(frame.get(), 0), "picture buffer");
}

void VideoEncoder::Parts::encode(const AVFrame* picture) {
  check(avcodec_send_frame(encoder.get(), picture), "a frame cannot be encoded");
  for (;;) {
    const int result = avcodec_receive_packet(encoder.get(), packet.get());
    if (result == AVERROR(EAGAIN) || result == AVERROR_EOF) return;
    check(result, "a frame cannot be encoded");
    packet->stream_index = stream->index;
    packet->duration = frame_ticks;
    av_packet_rescale_ts(packet.get(), encoder->time_base, stream->time_base);
    check(av_interleaved_write_frame(muxer.get(), packet.get()), "write failed");
  }
}

VideoEncoder::VideoEncoder(const std::string& file, const std::string& shown_name,
                           const VideoFormat& format, std::span<const std::string> encoders)
    : parts_(std::make_unique<Parts>()) {
  if (!(format.nominal_frame_rate_hz > 0.0) || !std::isfinite(format.nominal_frame_rate_hz))
    throw std::invalid_argument("VideoEncoder: nominal_frame_rate_hz must be positive");
  parts_->shown_name = shown_name;
  parts_->frame_ticks =
      std::max<std::int64_t>(1, std::llround(kVideoTicksHz / format.nominal_frame_rate_hz));
  const AVCodec* codec = first_present(encoders);
  if (codec == nullptr)
    parts_->fail("no video encoder", "this libavcodec has neither of those that are used");
  AVFormatContext* muxer = nullptr;
  parts_->check(avformat_alloc_output_context2(&muxer, nullptr, "mp4", file.c_str()), "container");
  parts_->muxer.reset(muxer);
  parts_->open_encoder(codec, format);
  parts_->open_file(file);
  parts_->open_scaler();
}

VideoEncoder::~VideoEncoder() = default;

void VideoEncoder::add(const cv::Mat& picture, std::int64_t ticks) {
  Parts& parts = *parts_;
  if (picture.type() != CV_8UC3 || picture.cols != parts.encoder->width ||
      picture.rows != parts.encoder->height)
    throw std::invalid_argument("VideoEncoder: picture must be 8-bit BGR of the format's size");
  parts.check(av_frame_make_writable(parts.frame.get()), "picture buffer");
  // libswscale reads four planes' worth of both, whatever the format.
  const std::array<const std::uint8_t*, 4> source{picture.data};
  const std::array<int, 4> stride_bytes{static_cast<int>(picture.step)};
  sws_scale(parts.scaler.get(), source.data(), stride_bytes.data(), 0, picture.rows,
            parts.frame->data, parts.frame->linesize);
  parts.frame->pts = ticks;
  parts.encode(parts.frame.get());
}

void VideoEncoder::finish() {
  Parts& parts = *parts_;
  parts.encode(nullptr);
  parts.check(av_write_trailer(parts.muxer.get()), "index cannot be written");
  parts.check(parts.muxer->pb->error, "write failed");
  parts.check(avio_closep(&parts.muxer->pb), "write failed");
}

}  // namespace vildar
