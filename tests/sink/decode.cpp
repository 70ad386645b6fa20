#include "sink/decode.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
}

#include <stdexcept>

namespace vildar::test {
namespace {

void check(int result, const char* what) {
  if (result < 0) throw std::runtime_error(what);
}

void drain(AVCodecContext* decoder, AVFrame* frame, AVRational time_base, DecodedClip& clip) {
  while (avcodec_receive_frame(decoder, frame) >= 0) {
    DecodedFrame decoded{static_cast<double>(frame->pts) * av_q2d(time_base), {}};
    for (int v = 0; v < frame->height; ++v) {
      const std::uint8_t* row = frame->data[0] + v * frame->linesize[0];
      decoded.luma.insert(decoded.luma.end(), row, row + frame->width);
    }
    clip.frames.push_back(std::move(decoded));
  }
}

}  // namespace

DecodedClip decode(const std::filesystem::path& path) {
  AVFormatContext* demuxer = nullptr;
  check(avformat_open_input(&demuxer, path.c_str(), nullptr, nullptr), "open");
  check(avformat_find_stream_info(demuxer, nullptr), "stream info");
  const AVStream* stream = demuxer->streams[0];
  const AVCodec* codec = avcodec_find_decoder(stream->codecpar->codec_id);
  AVCodecContext* decoder = avcodec_alloc_context3(codec);
  check(avcodec_parameters_to_context(decoder, stream->codecpar), "parameters");
  decoder->pkt_timebase = stream->time_base;
  check(avcodec_open2(decoder, codec, nullptr), "decoder");
  DecodedClip clip{codec->name, decoder->width, decoder->height, {}};
  AVPacket* packet = av_packet_alloc();
  AVFrame* frame = av_frame_alloc();
  while (av_read_frame(demuxer, packet) >= 0) {
    check(avcodec_send_packet(decoder, packet), "packet");
    av_packet_unref(packet);
    drain(decoder, frame, stream->time_base, clip);
  }
  avcodec_send_packet(decoder, nullptr);
  drain(decoder, frame, stream->time_base, clip);
  av_frame_free(&frame);
  av_packet_free(&packet);
  avcodec_free_context(&decoder);
  avformat_close_input(&demuxer);
  return clip;
}

}  // namespace vildar::test
