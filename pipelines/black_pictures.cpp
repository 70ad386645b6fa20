#include "pipelines/black_pictures.h"

namespace vildar {
namespace {

/// Share of the picture that is brighter than black.
double share_above_black(const LumaView& luma) {
  constexpr int kRows = 16, kColumns = 8;
  std::int64_t above = 0, all = 0;
  for (int v = kRows / 2; v < luma.height_px; v += kRows)
    for (int u = kColumns / 2; u < luma.width_px; u += kColumns, ++all)
      above += luma.code(u, v) > luma.black_code;
  return all > 0 ? static_cast<double>(above) / static_cast<double>(all) : 0.0;
}

}  // namespace

void BlackPictures::add(const Frame& frame, bool lit) {
  constexpr double kShows = 0.5, kBlack = 0.1, kLeast_s = 0.5;
  const double share = share_above_black(frame.luma);
  if (lit || share > kBlack) {
    showed_ = lit && share > kShows;
    now_.reset();
    return;
  }
  if (!showed_) return;
  const double time_s = seconds_of(frame.time);
  if (!now_) now_ = Stretch{time_s, time_s, 0};
  now_->to_s = time_s;
  ++now_->frames;
  const double length_s = now_->to_s - now_->from_s;
  if (length_s >= kLeast_s && (!longest_ || length_s >= longest_->to_s - longest_->from_s))
    longest_ = now_;
}

}  // namespace vildar
