#pragma once

#include <memory>

#include "types/frame.h"

struct AVFrame;
struct SwsContext;

namespace vildar {

using SharedPicture = std::shared_ptr<const AVFrame>;

/// The colour range a picture is in. Grey pictures that do not say are taken as full range, as
/// libswscale does; all others as limited.
struct PictureRange {
  bool full = false;
  bool assumed = false;
};
PictureRange range_of(const AVFrame& picture);

/// Views into planar YUV, semi-planar YUV or grey; `picture` must pass has_luma_plane().
void set_views(SharedPicture picture, Frame& frame);

/// Whether plane 0 is a readable plane of luma of 8 to 16 bits.
bool has_luma_plane(const AVFrame& picture);

/// A new picture whose luma is that of one field of `picture`, which must pass has_luma_plane():
/// rows of the other one, taken half a frame earlier or later, are the mean of their neighbours.
/// The top field has row 0.
SharedPicture one_field_of(const AVFrame& picture, bool top);

/// Makes a luma plane where there is none: packed YUV stays in its range, RGB becomes full-range
/// BT.709.
class LumaMaker {
 public:
  LumaMaker() = default;
  ~LumaMaker();
  LumaMaker(const LumaMaker&) = delete;
  LumaMaker& operator=(const LumaMaker&) = delete;

  /// A new picture; null where libswscale does not know the pixel format.
  SharedPicture converted(const AVFrame& picture);

 private:
  SwsContext* scaler_ = nullptr;
};

}  // namespace vildar
