#include "capture/picture_view.h"

#include <array>
#include <cstdint>
#include <new>

extern "C" {
#include <libavutil/frame.h>
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

namespace vildar {
namespace {

const AVPixFmtDescriptor* description_of(const AVFrame& picture) {
  return av_pix_fmt_desc_get(static_cast<AVPixelFormat>(picture.format));
}

bool is_grey(const AVPixFmtDescriptor& pixel) { return pixel.nb_components <= 2; }

/// Bits from the lowest to the highest used: pixels stored in the high bits of a word (P010) are
/// read as 16-bit ones.
int bits_of(const AVComponentDescriptor& component) { return component.depth + component.shift; }

AVPixelFormat planar_format(const AVPixFmtDescriptor& pixel) {
  const bool deep = pixel.comp[0].depth > 8 || (pixel.flags & AV_PIX_FMT_FLAG_FLOAT) != 0;
  if (is_grey(pixel) && (pixel.flags & AV_PIX_FMT_FLAG_PAL) == 0)
    return deep ? AV_PIX_FMT_GRAY16LE : AV_PIX_FMT_GRAY8;
  return deep ? AV_PIX_FMT_YUV444P16LE : AV_PIX_FMT_YUV444P;
}

std::shared_ptr<AVFrame> owned(AVFrame* frame) {
  if (frame == nullptr) throw std::bad_alloc();
  return {frame, [](AVFrame* last) { av_frame_free(&last); }};
}

/// Gives each row of one parity the mean of its neighbours.
template <class Sample>
void interpolate_rows(AVFrame& picture, int first) {
  const auto row = [&](int v) {
    return reinterpret_cast<Sample*>(picture.data[0] + v * std::ptrdiff_t{picture.linesize[0]});
  };
  for (int v = first; v < picture.height; v += 2) {
    const Sample* const above = row(v > 0 ? v - 1 : v + 1);
    const Sample* const below = row(v + 1 < picture.height ? v + 1 : v - 1);
    Sample* const between = row(v);
    for (int u = 0; u < picture.width; ++u)
      between[u] = static_cast<Sample>((above[u] + below[u] + 1) / 2);
  }
}

}  // namespace

PictureRange range_of(const AVFrame& picture) {
  if (picture.color_range == AVCOL_RANGE_JPEG) return {.full = true};
  if (picture.color_range == AVCOL_RANGE_MPEG) return {};
  switch (picture.format) {
    case AV_PIX_FMT_YUVJ420P:
    case AV_PIX_FMT_YUVJ422P:
    case AV_PIX_FMT_YUVJ444P:
    case AV_PIX_FMT_YUVJ440P:
    case AV_PIX_FMT_YUVJ411P: return {.full = true};
    default: return {.full = is_grey(*description_of(picture)), .assumed = true};
  }
}

bool has_luma_plane(const AVFrame& picture) {
  const AVPixFmtDescriptor* pixel = description_of(picture);
  constexpr std::uint64_t kUnfit = AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL |
                                   AV_PIX_FMT_FLAG_HWACCEL | AV_PIX_FMT_FLAG_BITSTREAM |
                                   AV_PIX_FMT_FLAG_BAYER | AV_PIX_FMT_FLAG_FLOAT;
  if (pixel == nullptr || (pixel->flags & kUnfit) != 0) return false;
  const AVComponentDescriptor& luma = pixel->comp[0];
  const int bits = bits_of(luma);
  if (bits < 8 || bits > 16 || luma.plane != 0 || luma.offset != 0) return false;
  if (luma.shift != 0 && bits != 16) return false;
  if (bits > 8 && (pixel->flags & AV_PIX_FMT_FLAG_BE) != 0) return false;
  return luma.step == (bits > 8 ? 2 : 1);
}

void set_views(SharedPicture picture, Frame& frame) {
  const AVPixFmtDescriptor& pixel = *description_of(*picture);
  const int bits = bits_of(pixel.comp[0]);
  const bool full = range_of(*picture).full;
  LumaView& luma = frame.luma;
  luma.data = picture->data[0];
  luma.stride_bytes = picture->linesize[0];
  luma.width_px = picture->width;
  luma.height_px = picture->height;
  luma.bit_depth = bits;
  luma.black_code = full ? 0 : 16 << (bits - 8);
  luma.white_code = full ? (1 << bits) - 1 : 235 << (bits - 8);

  const AVComponentDescriptor& cb = pixel.comp[1];
  const AVComponentDescriptor& cr = pixel.comp[2];
  frame.chroma = {};
  if (pixel.nb_components >= 3 && picture->linesize[cb.plane] == picture->linesize[cr.plane]) {
    frame.chroma = {.cb = picture->data[cb.plane] + cb.offset,
                    .cr = picture->data[cr.plane] + cr.offset,
                    .stride_bytes = picture->linesize[cb.plane],
                    .step_bytes = cb.step / (bits > 8 ? 2 : 1),
                    .shift_u = pixel.log2_chroma_w,
                    .shift_v = pixel.log2_chroma_h,
                    .bit_depth = bits_of(cb)};
  }
  luma.owner = std::move(picture);
}

SharedPicture one_field_of(const AVFrame& picture, bool top) {
  std::shared_ptr<AVFrame> field = owned(av_frame_clone(&picture));
  if (av_frame_make_writable(field.get()) < 0) throw std::bad_alloc();
  if (picture.height < 2) return field;
  const int other = top ? 1 : 0;
  if (bits_of(description_of(picture)->comp[0]) > 8)
    interpolate_rows<std::uint16_t>(*field, other);
  else
    interpolate_rows<std::uint8_t>(*field, other);
  return field;
}

LumaMaker::~LumaMaker() { sws_freeContext(scaler_); }

SharedPicture LumaMaker::converted(const AVFrame& picture) {
  const AVPixFmtDescriptor* pixel = description_of(picture);
  const auto source = static_cast<AVPixelFormat>(picture.format);
  if (pixel == nullptr || sws_isSupportedInput(source) == 0) return nullptr;
  const AVPixelFormat target = planar_format(*pixel);
  constexpr std::uint64_t kRgb = AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL | AV_PIX_FMT_FLAG_BAYER;
  const bool rgb =
      (pixel->flags & kRgb) != 0 || source == AV_PIX_FMT_XYZ12LE || source == AV_PIX_FMT_XYZ12BE;
  const bool full = rgb || range_of(picture).full;
  scaler_ = sws_getCachedContext(
      scaler_, picture.width, picture.height, source, picture.width, picture.height, target,
      SWS_POINT | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INP | SWS_FULL_CHR_H_INT | SWS_BITEXACT,
      nullptr, nullptr, nullptr);
  if (scaler_ == nullptr) return nullptr;
  const int* weights = sws_getCoefficients(SWS_CS_ITU709);
  sws_setColorspaceDetails(scaler_, weights, full ? 1 : 0, weights, full ? 1 : 0, 0, 1 << 16,
                           1 << 16);

  const std::shared_ptr<AVFrame> made = owned(av_frame_alloc());
  made->width = picture.width;
  made->height = picture.height;
  made->format = target;
  made->color_range = full ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
  if (av_frame_get_buffer(made.get(), 0) < 0) throw std::bad_alloc();
  if (sws_scale(scaler_, picture.data, picture.linesize, 0, picture.height, made->data,
                made->linesize) < 0)
    return nullptr;
  return made;
}

}  // namespace vildar
