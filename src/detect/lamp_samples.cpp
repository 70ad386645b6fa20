#include "detect/lamp_samples.h"

#include <algorithm>
#include <cmath>

#include "core/quantity.h"
#include "optics/disc_image.h"

namespace vildar {
namespace {

constexpr double kMostPixels = 600.0;  // of one lamp, beside those about its rim
constexpr double kMostRimPixels = 2000.0;
constexpr double kDenseSizes = 3.0;  // of a lamp that does not clip, its size
constexpr double kRimInside_px = 5.0, kRimOutside_px = 3.0;
/// Compression digs holes into clipped areas: a pixel this far inside the rim that nearly clips
/// does clip.
constexpr double kHoleDepth_px = 1.5, kHoleLight = 0.8;

double square_of(double distance_px) { return distance_px > 0.0 ? distance_px * distance_px : 0.0; }

int stride_of(double area_px2, double most) {
  return std::max(1, static_cast<int>(std::ceil(area_px2 / most)));
}

/// Of numbers in a row those that a stride divides.
class Every {
 public:
  Every(int first, int stride) : stride_(stride), left_((stride - first % stride) % stride) {}
  bool next() {
    if (left_-- > 0) return false;
    left_ = stride_ - 1;
    return true;
  }

 private:
  int stride_, left_;
};

/// Whole numbers in [from, to] that are places of a row or column of so many pixels.
struct Range {
  int first, last;
  Range(double from, double to, int size)
      : first(std::max(0, static_cast<int>(std::ceil(from)))),
        last(std::min(size - 1, static_cast<int>(std::floor(to)))) {}
};

}  // namespace

void LampSamples::add(int u, int v, float light_here, float place2_here) {
  u_px.push_back(static_cast<float>(u - origin_px.x()));
  v_px.push_back(static_cast<float>(v - origin_px.y()));
  light.push_back(light_here);
  place2.push_back(place2_here);
}

void LampSamples::fill_up() {
  keep.resize(light.size(), 1.0F);
  const std::size_t batches = (light.size() + DiscImage::kBatch - 1) / DiscImage::kBatch;
  for (std::vector<float>* one : {&u_px, &v_px, &light, &place2, &keep})
    one->resize(batches * DiscImage::kBatch, 0.0F);
}

void LampSamples::gather(const FrameLight& frame, std::span<const LampGuess> guesses,
                         std::span<const double> reach_px, std::span<const OtherLamp> others_in) {
  for (std::vector<float>* one : {&u_px, &v_px, &light, &place2, &keep}) one->clear();
  clipped_.clear();
  origin_px = guesses.front().centre_px.array().round();
  const LumaView& luma = frame.luma;
  for (std::size_t i = 0; i < guesses.size(); ++i) {
    const double reach = reach_px[i], rim = guesses[i].rim_px;
    const Eigen::Vector2d& centre = guesses[i].centre_px;
    const double dense = rim > 0.0 ? rim + kRimOutside_px : kDenseSizes * guesses[i].size_px;
    const int stride = stride_of(kPi * (reach * reach - dense * dense), kMostPixels);
    const int rim_stride =
        stride_of(2.0 * kPi * rim * (kRimInside_px + kRimOutside_px), kMostRimPixels);
    const double dense2 = square_of(dense), per_reach2 = 1.0 / square_of(reach);
    const Range rows(centre.y() - reach, centre.y() + reach, luma.height_px);
    for (int v = rows.first; v <= rows.last; ++v) {
      const double dv2 = square_of(std::abs(v - centre.y()));
      const double half_px = std::sqrt(std::max(square_of(reach) - dv2, 0.0));
      const Range columns(centre.x() - half_px, centre.x() + half_px, luma.width_px);
      Every outer(columns.first + 2 * v, stride), about_rim(columns.first + 2 * v, rim_stride);
      for (int u = columns.first; u <= columns.last; ++u) {
        const bool in_outer = outer.next(), in_rim = about_rim.next();
        const double du = u - centre.x(), distance2 = du * du + dv2;
        if (!(distance2 > dense2 ? in_outer : in_rim)) continue;
        bool left_out = false, inside = false;
        for (std::size_t j = 0; j < guesses.size(); ++j) {
          const double from2 =
              j == i ? distance2 : (Eigen::Vector2d(u, v) - guesses[j].centre_px).squaredNorm();
          left_out |= j < i && from2 <= square_of(reach_px[j]);
          // Deep inside a clipped area every model agrees.
          left_out |= from2 < square_of(guesses[j].rim_px - kRimInside_px);
          inside |= from2 < square_of(guesses[j].rim_px - kHoleDepth_px);
        }
        for (const OtherLamp& other : others_in)
          left_out |=
              (Eigen::Vector2d(u, v) - other.centre_px).squaredNorm() < square_of(other.core_px);
        if (left_out) continue;
        const int code = luma.code(u, v);
        const float here = frame.linear[code];
        const auto place2_here = static_cast<float>(distance2 * per_reach2);
        const bool hole = inside && here > kHoleLight * frame.clip_light;
        if (hole || code >= frame.clip_code)
          clipped_.push_back({u, v, here, place2_here});
        else
          add(u, v, here, place2_here);
      }
    }
  }
  used = light.size() + clipped_.size();
  fill_up();
  clear = size();
  for (const Clipped& one : clipped_) add(one.u, one.v, one.light, one.place2);
  fill_up();
  others.assign(size(), 0.0F);
}

void LampSamples::keep_within(double share) {
  if (share >= 1.0) return;
  const auto most = static_cast<float>(share * share);
  for (std::size_t k = 0; k < size(); ++k) {
    if (keep[k] == 0.0F || place2[k] <= most) continue;
    keep[k] = 0.0F;
    --used;
  }
}

}  // namespace vildar
