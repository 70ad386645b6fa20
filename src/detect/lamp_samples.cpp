#include "detect/lamp_samples.h"

#include <algorithm>
#include <cmath>

#include "core/quantity.h"
#include "optics/disc_image.h"

namespace vildar {
namespace {

// Of one lamp, beside those about its rim, or within so many sizes of its middle. A lamp that does
// not clip is told by these pixels alone.
constexpr double kMostPixels = 600.0, kMostUnclippedPixels = 1200.0;
constexpr double kMostRimPixels = 2000.0;
constexpr double kDenseSizes = 3.0;  // of a lamp that does not clip, its size
constexpr double kRimInside_px = 5.0, kRimOutside_px = 3.0;
/// Compression digs holes into clipped areas: a pixel this far inside the rim that nearly clips
/// does clip.
constexpr double kHoleDepth_px = 1.5, kHoleLight = 0.8;
/// So far from a rim coding errs no more than elsewhere; halfway a third of that in variance.
constexpr double kCodedRim_px = 4.0;

double square_of(double distance_px) { return distance_px > 0.0 ? distance_px * distance_px : 0.0; }

std::size_t in_batches(std::size_t pixels) {
  return (pixels + DiscImage::kBatch - 1) / DiscImage::kBatch * DiscImage::kBatch;
}

int stride_of(double area_px2, double most) {
  return std::max(1, static_cast<int>(std::ceil(area_px2 / most)));
}

/// Whole numbers in [from, to] that are places of a row or column of so many pixels.
struct Range {
  int first, last;
  Range(double from, double to, int size)
      : first(std::max(0, static_cast<int>(std::ceil(from)))),
        last(std::min(size - 1, static_cast<int>(std::floor(to)))) {}
};

double half_chord_px(double radius2, double away2) {
  return std::sqrt(std::max(radius2 - away2, 0.0));
}

/// Share of a pixel's information that counts so far from a rim at which errors are larger.
double share_at_rim(double from_rim_px, double rim_factor) {
  const double inside = 1.0 - square_of(std::abs(from_rim_px) / kCodedRim_px);
  if (inside <= 0.0) return 1.0;
  const double square = inside * inside;
  return 1.0 / (1.0 + (rim_factor * rim_factor - 1.0) * square * square);
}

/// Light of a pixel before the picture was softened, to first order in the variance.
float sharpened(const FrameLight& frame, int u, int v, double variance_px2) {
  const LumaView& luma = frame.luma;
  const int code = luma.code(u, v);
  if (u == 0 || v == 0 || u + 1 == luma.width_px || v + 1 == luma.height_px)
    return frame.linear[code];
  const int around = luma.code(u - 1, v) + luma.code(u + 1, v) + luma.code(u, v - 1) +
                     luma.code(u, v + 1) - 4 * code;
  const double last = static_cast<double>(frame.linear.size() - 1);
  const double before = std::clamp(code - 0.5 * variance_px2 * around, 0.0, last);
  const double whole = std::min(std::floor(before), last - 1.0);
  const auto at = static_cast<std::size_t>(whole);
  return std::lerp(frame.linear[at], frame.linear[at + 1], static_cast<float>(before - whole));
}

}  // namespace

/// Writes pixels from place `first` on, and those that do not count up to a whole batch.
void LampSamples::set(std::size_t first, std::span<const Pixel> pixels) {
  for (std::size_t k = 0; k < pixels.size(); ++k) {
    const Pixel& pixel = pixels[k];
    u_px[first + k] = pixel.u_px;
    v_px[first + k] = pixel.v_px;
    light[first + k] = pixel.light;
    place2[first + k] = pixel.place2;
    keep[first + k] = pixel.keep;
  }
  const auto from = static_cast<std::ptrdiff_t>(first + pixels.size());
  const auto to = static_cast<std::ptrdiff_t>(first + in_batches(pixels.size()));
  for (std::vector<float>* one : {&u_px, &v_px, &light, &place2, &keep})
    std::fill(one->begin() + from, one->begin() + to, 0.0F);
}

void LampSamples::list_circles(std::size_t lamp, int v, std::span<const LampGuess> guesses,
                               std::span<const double> reach_px,
                               std::span<const OtherLamp> others_in) {
  left_out_.clear();
  holes_.clear();
  const auto list = [&](std::vector<Chord>& in, const Eigen::Vector2d& centre_px,
                        double radius_px) {
    const double half2 = square_of(radius_px) - square_of(std::abs(v - centre_px.y()));
    if (!(half2 > 0.0)) return;
    const double half_px = std::sqrt(half2);
    in.push_back({static_cast<int>(std::ceil(centre_px.x() - half_px)),
                  static_cast<int>(std::floor(centre_px.x() + half_px))});
  };
  for (std::size_t j = 0; j < guesses.size(); ++j) {
    if (j < lamp) list(left_out_, guesses[j].centre_px, reach_px[j]);
    // Deep inside a clipped area every model agrees.
    list(left_out_, guesses[j].centre_px, guesses[j].rim_px - kRimInside_px);
    list(holes_, guesses[j].centre_px, guesses[j].rim_px - kHoleDepth_px);
  }
  for (const OtherLamp& other : others_in) list(left_out_, other.centre_px, other.core_px);
}

void LampSamples::gather(const FrameLight& frame, std::span<const LampGuess> guesses,
                         std::span<const double> reach_px, std::span<const OtherLamp> others_in) {
  used = 0;
  origin_px = guesses.front().centre_px.array().round();
  const LumaView& luma = frame.luma;
  const auto chord_at = [](const std::vector<Chord>& chords, int u) {
    return std::find_if(chords.begin(), chords.end(),
                        [u](const Chord& chord) { return u >= chord.first && u <= chord.last; });
  };
  std::size_t clear_count = 0, clipped_count = 0;
  const double hole_light = kHoleLight * frame.clip_light;
  for (std::size_t i = 0; i < guesses.size(); ++i) {
    const double reach2 = square_of(reach_px[i]), rim = guesses[i].rim_px;
    const Eigen::Vector2d& centre = guesses[i].centre_px;
    const double dense = rim > 0.0 ? rim + kRimOutside_px : kDenseSizes * guesses[i].size_px;
    const double dense2 = square_of(dense), per_reach2 = 1.0 / reach2;
    const double softened_px2 = frame.coding && rim == 0.0 ? frame.coding->softened_px2 : 0.0;
    const double rim_factor = frame.coding && rim > 0.0 ? frame.coding->rim_factor : 1.0;
    const int stride =
        stride_of(kPi * (reach2 - dense2), rim > 0.0 ? kMostPixels : kMostUnclippedPixels);
    const int rim_stride =
        stride_of(2.0 * kPi * rim * (kRimInside_px + kRimOutside_px), kMostRimPixels);
    const Range rows(centre.y() - reach_px[i], centre.y() + reach_px[i], luma.height_px);
    for (int v = rows.first; v <= rows.last; ++v) {
      const double dv2 = square_of(std::abs(v - centre.y()));
      list_circles(i, v, guesses, reach_px, others_in);
      const auto take = [&](int first, int last, int every) {
        int u = first + (every - (first + 2 * v) % every) % every;
        while (u <= last) {
          const auto chord = chord_at(left_out_, u);
          if (chord != left_out_.end()) {
            u += (chord->last - u + every) / every * every;
            continue;
          }
          int end = last;
          for (const Chord& next : left_out_)
            if (next.first > u) end = std::min(end, next.first - 1);
          for (std::vector<Pixel>* one : {&clear_, &clipped_})
            if (const auto most = used + static_cast<std::size_t>(end - u + 1); one->size() < most)
              one->resize(2 * most);
          for (; u <= end; u += every, ++used) {
            const int code = luma.code(u, v);
            const float here = frame.linear[code];
            const double du = u - centre.x();
            const bool clips = code >= frame.clip_code ||
                               (here > hole_light && chord_at(holes_, u) != holes_.end());
            Pixel& pixel = clips ? clipped_[clipped_count++] : clear_[clear_count++];
            const double away2 = du * du + dv2;
            pixel = {static_cast<float>(u - origin_px.x()), static_cast<float>(v - origin_px.y()),
                     softened_px2 > 0.0 ? sharpened(frame, u, v, softened_px2) : here,
                     static_cast<float>(away2 * per_reach2), 1.0F};
            if (rim_factor > 1.0 && !clips)
              pixel.keep = static_cast<float>(share_at_rim(std::sqrt(away2) - rim, rim_factor));
          }
        }
      };
      const double half_px = half_chord_px(reach2, dv2);
      const Range all(centre.x() - half_px, centre.x() + half_px, luma.width_px);
      if (dv2 > dense2) {
        take(all.first, all.last, stride);
        continue;
      }
      const double dense_px = std::min(half_chord_px(dense2, dv2), half_px);
      const Range middle(centre.x() - dense_px, centre.x() + dense_px, luma.width_px);
      take(all.first, std::min(middle.first - 1, all.last), stride);
      take(middle.first, middle.last, rim_stride);
      take(std::max(middle.last + 1, all.first), all.last, stride);
    }
  }
  clear = in_batches(clear_count);
  for (std::vector<float>* one : {&u_px, &v_px, &light, &place2, &keep})
    one->resize(clear + in_batches(clipped_count));
  set(0, std::span(clear_).first(clear_count));
  set(clear, std::span(clipped_).first(clipped_count));
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
