#include "capture/row_maxima.h"

#include <algorithm>
#include <cstddef>
#include <new>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavutil/pixdesc.h>
}

// Highway compiles this file once per instruction set and picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "capture/row_maxima.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace vildar {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
std::uint8_t greatest_here(const std::uint8_t* codes, int count) {
  return *std::max_element(codes, codes + count);
}
#else
std::uint8_t greatest_here(const std::uint8_t* codes, int count) {
  const hn::ScalableTag<std::uint8_t> tag;
  const hn::Repartition<std::uint16_t, decltype(tag)> pairs;
  const int lanes = static_cast<int>(hn::Lanes(tag)), stretch = 4 * lanes;
  if (count < stretch) return *std::max_element(codes, codes + count);
  auto a = hn::Zero(tag), b = a, c = a, d = a;
  const auto look_at = [&](const std::uint8_t* from) HWY_ATTR {
    a = hn::Max(a, hn::LoadU(tag, from));
    b = hn::Max(b, hn::LoadU(tag, from + lanes));
    c = hn::Max(c, hn::LoadU(tag, from + 2 * lanes));
    d = hn::Max(d, hn::LoadU(tag, from + 3 * lanes));
  };
  const std::uint8_t* const last = codes + count - stretch;
  for (; codes < last; codes += stretch) look_at(codes);
  look_at(last);
  const auto both = hn::BitCast(pairs, hn::Max(hn::Max(a, b), hn::Max(c, d)));
  const auto most = hn::Max(hn::ShiftRight<8>(both), hn::And(both, hn::Set(pairs, 0xff)));
  return static_cast<std::uint8_t>(hn::GetLane(hn::MaxOfLanes(pairs, most)));
}
#endif

}  // namespace HWY_NAMESPACE
}  // namespace vildar
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vildar {
namespace {

HWY_EXPORT(greatest_here);

/// Of the rows of a picture as it is stored, one code for each behind this.
struct RowMaxima {
  const std::uint8_t* plane = nullptr;
  int width_px = 0, height_px = 0;
  int rows_told = 0;  ///< from the top on; all were told in turn
  bool in_turn = true;

  std::uint8_t* codes() { return reinterpret_cast<std::uint8_t*>(this + 1); }
};

RowMaxima* noted_with(const AVFrame& picture) {
  return picture.opaque_ref == nullptr ? nullptr
                                       : reinterpret_cast<RowMaxima*>(picture.opaque_ref->data);
}

int get_picture(AVCodecContext* codec, AVFrame* picture, int flags) {
  if (const int error = avcodec_default_get_buffer2(codec, picture, flags); error < 0) return error;
  const AVPixFmtDescriptor* pixel =
      av_pix_fmt_desc_get(static_cast<AVPixelFormat>(picture->format));
  if (pixel == nullptr || pixel->comp[0].depth != 8 || pixel->comp[0].step != 1) return 0;
  picture->opaque_ref =
      av_buffer_alloc(sizeof(RowMaxima) + static_cast<std::size_t>(picture->height));
  if (picture->opaque_ref == nullptr) return AVERROR(ENOMEM);
  new (picture->opaque_ref->data) RowMaxima{
      .plane = picture->data[0], .width_px = picture->width, .height_px = picture->height};
  return 0;
}

void note_rows(AVCodecContext*, const AVFrame* picture, int*, int first_row, int, int rows) {
  RowMaxima* maxima = noted_with(*picture);
  if (maxima == nullptr) return;
  maxima->in_turn &= first_row == maxima->rows_told && rows <= maxima->height_px - first_row;
  if (!maxima->in_turn) return;
  const std::uint8_t* row = maxima->plane + first_row * std::ptrdiff_t{picture->linesize[0]};
  for (; rows > 0; --rows, row += picture->linesize[0])
    maxima->codes()[maxima->rows_told++] =
        HWY_DYNAMIC_DISPATCH(greatest_here)(row, maxima->width_px);
}

}  // namespace

void note_row_maxima(AVCodecContext& codec) {
  codec.get_buffer2 = get_picture;
  codec.draw_horiz_band = note_rows;
}

const std::uint8_t* row_maxima_of(const AVFrame& picture) {
  RowMaxima* maxima = noted_with(picture);
  if (maxima == nullptr || !maxima->in_turn) return nullptr;
  // What is shown may begin further down and to the right.
  const std::ptrdiff_t offset = picture.data[0] - maxima->plane, stride = picture.linesize[0];
  if (offset < 0 || offset % stride + picture.width > maxima->width_px ||
      offset / stride + picture.height > maxima->rows_told)
    return nullptr;
  return maxima->codes() + offset / stride;
}

}  // namespace vildar
#endif  // HWY_ONCE
