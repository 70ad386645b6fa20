#include "support/clip_writer.h"

#include <memory>
#include <stdexcept>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/display.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
}

namespace vildar::test {
namespace {

int checked(int result, const char* what) {
  if (result < 0) throw std::runtime_error(std::string("clip writer: ") + what + " failed");
  return result;
}

struct Freed {
  void operator()(AVFormatContext* container) const {
    avio_closep(&container->pb);
    avformat_free_context(container);
  }
  void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};
template <class T>
using Owned = std::unique_ptr<T, Freed>;

AVDictionary* dictionary_of(const std::map<std::string, std::string>& options) {
  AVDictionary* dictionary = nullptr;
  for (const auto& [key, value] : options) av_dict_set(&dictionary, key.c_str(), value.c_str(), 0);
  return dictionary;
}

AVRational time_base_of(const ClipSpec& spec) {
  return spec.stamps_ms.empty() ? AVRational{1, spec.rate_hz} : AVRational{1, 1000};
}

Owned<AVCodecContext> open_encoder(const ClipSpec& spec, const AVFormatContext& container) {
  const AVCodec* encoder = avcodec_find_encoder_by_name(spec.encoder.c_str());
  if (encoder == nullptr) throw std::runtime_error("clip writer: no encoder " + spec.encoder);
  Owned<AVCodecContext> codec(avcodec_alloc_context3(encoder));
  codec->width = spec.width_px;
  codec->height = spec.height_px;
  codec->pix_fmt = av_get_pix_fmt(spec.pixel_format.c_str());
  codec->time_base = time_base_of(spec);
  if (spec.stamps_ms.empty()) codec->framerate = {spec.rate_hz, 1};
  codec->gop_size = spec.keyframe_interval;
  codec->thread_count = 1;
  codec->strict_std_compliance = FF_COMPLIANCE_UNOFFICIAL;
  if (spec.state_range) codec->color_range = spec.full_range ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
  if ((container.oformat->flags & AVFMT_GLOBALHEADER) != 0)
    codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  AVDictionary* options = dictionary_of(spec.encoder_options);
  const int result = avcodec_open2(codec.get(), encoder, &options);
  av_dict_free(&options);
  checked(result, "avcodec_open2");
  return codec;
}

void drain(AVCodecContext& codec, AVFormatContext& container, AVPacket& packet) {
  while (avcodec_receive_packet(&codec, &packet) >= 0) {
    av_packet_rescale_ts(&packet, codec.time_base, container.streams[0]->time_base);
    packet.stream_index = 0;
    checked(av_interleaved_write_frame(&container, &packet), "av_interleaved_write_frame");
  }
}

}  // namespace

Painter luma_painter(std::function<int(int frame, int u, int v)> code) {
  return [code = std::move(code)](AVFrame& picture, int frame) {
    const AVPixFmtDescriptor& pixel =
        *av_pix_fmt_desc_get(static_cast<AVPixelFormat>(picture.format));
    const bool deep = pixel.comp[0].depth > 8;
    for (int plane = 0; plane < av_pix_fmt_count_planes(static_cast<AVPixelFormat>(picture.format));
         ++plane) {
      const int shift_u = plane == 0 ? 0 : pixel.log2_chroma_w,
                shift_v = plane == 0 ? 0 : pixel.log2_chroma_h;
      const int width = -((-picture.width) >> shift_u), height = -((-picture.height) >> shift_v);
      for (int v = 0; v < height; ++v) {
        std::uint8_t* row = picture.data[plane] + v * picture.linesize[plane];
        for (int u = 0; u < width; ++u) {
          const int value = plane == 0 ? code(frame, u, v) : 1 << (pixel.comp[0].depth - 1);
          row[deep ? 2 * u : u] = static_cast<std::uint8_t>(value);
          if (deep) row[2 * u + 1] = static_cast<std::uint8_t>(value >> 8);
        }
      }
    }
  };
}

Painter index_painter() {
  return [](AVFrame& picture, int frame) {
    const int bar_px = picture.width / 8;
    luma_painter([bar_px](int index, int u, int) {
      return (index >> std::min(u / bar_px, 7) & 1) != 0 ? 210 : 40;
    })(picture, frame);
  };
}

void write_clip(const ClipSpec& spec, const Painter& paint) {
  av_log_set_level(AV_LOG_QUIET);
  AVFormatContext* made = nullptr;
  checked(avformat_alloc_output_context2(&made, nullptr, nullptr, spec.path.c_str()),
          "no such container:");
  const Owned<AVFormatContext> container(made);
  const Owned<AVCodecContext> codec = open_encoder(spec, *container);
  AVStream* stream = avformat_new_stream(container.get(), nullptr);
  checked(avcodec_parameters_from_context(stream->codecpar, codec.get()),
          "avcodec_parameters_from_context");
  stream->sample_aspect_ratio = {spec.pixel_aspect[0], spec.pixel_aspect[1]};
  stream->codecpar->sample_aspect_ratio = stream->sample_aspect_ratio;
  stream->time_base = codec->time_base;
  if (spec.stamps_ms.empty()) stream->avg_frame_rate = codec->framerate;
  if (spec.rotate_clockwise_deg != 0) {
    auto* matrix = reinterpret_cast<std::int32_t*>(
        av_stream_new_side_data(stream, AV_PKT_DATA_DISPLAYMATRIX, 9 * sizeof(std::int32_t)));
    av_display_rotation_set(matrix,
                            spec.rotate_clockwise_deg);  // the function's own angle is clockwise
  }
  checked(avio_open(&container->pb, spec.path.c_str(), AVIO_FLAG_WRITE), "avio_open");
  AVDictionary* options = dictionary_of(spec.muxer_options);
  const int header = avformat_write_header(container.get(), &options);
  av_dict_free(&options);
  checked(header, "avformat_write_header");

  const Owned<AVPacket> packet(av_packet_alloc());
  for (int frame = 0; frame < spec.frames; ++frame) {
    const Owned<AVFrame> picture(av_frame_alloc());
    picture->width = spec.width_px;
    picture->height = spec.height_px;
    picture->format = codec->pix_fmt;
    picture->color_range = codec->color_range;
    checked(av_frame_get_buffer(picture.get(), 0), "av_frame_get_buffer");
    paint(*picture, frame);
    picture->pts = spec.stamps_ms.empty() ? frame : spec.stamps_ms[static_cast<std::size_t>(frame)];
    checked(avcodec_send_frame(codec.get(), picture.get()), "avcodec_send_frame");
    drain(*codec, *container, *packet);
  }
  checked(avcodec_send_frame(codec.get(), nullptr), "avcodec_send_frame at the end");
  drain(*codec, *container, *packet);
  checked(av_write_trailer(container.get()), "av_write_trailer");
}

}  // namespace vildar::test
