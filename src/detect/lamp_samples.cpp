#include "detect/lamp_samples.h"

#include <algorithm>
#include <cmath>

#include "core/quantity.h"
#include "optics/disc_image.h"

namespace vildar {
namespace {

// Of one lamp that does not clip, beside those within so many sizes of its middle; and about the
// rim of one that does. See FrameLight for those about that.
constexpr double kMostWingPixels = 600.0, kMostUnclippedPixels = 1200.0;
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

struct Span {
  std::size_t first, end;
};

Eigen::Map<Eigen::ArrayXf> part_of(std::vector<float>& row, Span of) {
  return {row.data() + of.first, static_cast<Eigen::Index>(of.end - of.first)};
}

/// Of pixels that a lamp `centre_px` from the origin brought in.
void set_places(PixelRows& rows, Span of, const Eigen::Vector2f& centre_px, double reach_px) {
  part_of(rows.place2, of) = ((part_of(rows.u_px, of) - centre_px.x()).square() +
                              (part_of(rows.v_px, of) - centre_px.y()).square()) *
                             static_cast<float>(1.0 / (reach_px * reach_px));
  part_of(rows.keep, of) = 1.0F;
}

/// Less of what counts about a rim at which errors are larger.
void weigh_rim(PixelRows& rows, Span of, double reach_px, double rim_px, double rim_factor) {
  const auto per_reach = static_cast<float>(reach_px / kCodedRim_px);
  const auto rim = static_cast<float>(rim_px / kCodedRim_px);
  part_of(rows.keep, of) =
      (1.0F + static_cast<float>(rim_factor * rim_factor - 1.0) *
                  (1.0F - (part_of(rows.place2, of).sqrt() * per_reach - rim).square())
                      .max(0.0F)
                      .square()
                      .square())
          .inverse();
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

void PixelRows::resize(std::size_t pixels) {
  for (std::vector<float>* one : {&u_px, &v_px, &light, &place2, &keep}) one->resize(pixels);
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

/// Every so many pixels of a row, but those of circles that are left out.
template <class T>
void LampSamples::take(const FrameLight& frame, int v, Chord columns, int every,
                       double softened_px2) {
  const auto chord_at = [](const std::vector<Chord>& chords, int u) {
    return std::find_if(chords.begin(), chords.end(),
                        [u](const Chord& chord) { return u >= chord.first && u <= chord.last; });
  };
  const T* const codes = reinterpret_cast<const T*>(frame.luma.row(v));
  const float* const linear = frame.linear.data();
  const int clip_code = frame.clip_code;
  const auto hole_light = static_cast<float>(kHoleLight * frame.clip_light);
  const auto from_u = static_cast<int>(origin_px.x());
  const auto v_here = static_cast<float>(v - origin_px.y());
  int u = columns.first + (every - (columns.first + 2 * v) % every) % every;
  while (u <= columns.last) {
    const auto chord = chord_at(left_out_, u);
    if (chord != left_out_.end()) {
      u += (chord->last - u + every) / every * every;
      continue;
    }
    int end = columns.last;
    for (const Chord& next : left_out_)
      if (next.first > u) end = std::min(end, next.first - 1);
    const auto more = static_cast<std::size_t>(end - u + 1);
    if (size() < clear_count_ + more) resize(clear_count_ + more);
    if (clipped_.keep.size() < clipped_count_ + more) clipped_.resize(clipped_count_ + more);
    float *const to_u = u_px.data(), *const to_v = v_px.data(), *const to_light = light.data();
    std::size_t at = clear_count_;
    for (; u <= end; u += every) {
      const int code = codes[u];
      const float here = linear[code];
      to_u[at] = static_cast<float>(u - from_u);
      to_v[at] = v_here;
      to_light[at] = softened_px2 > 0.0 ? sharpened(frame, u, v, softened_px2) : here;
      if (code < clip_code && (here <= hole_light || chord_at(holes_, u) == holes_.end())) {
        ++at;
        continue;
      }
      clipped_.u_px[clipped_count_] = to_u[at];
      clipped_.v_px[clipped_count_] = v_here;
      clipped_.light[clipped_count_++] = to_light[at];
    }
    clear_count_ = at;
  }
}

void LampSamples::gather(const FrameLight& frame, std::span<const LampGuess> guesses,
                         std::span<const double> reach_px, std::span<const OtherLamp> others_in) {
  origin_px = guesses.front().centre_px.array().round();
  const LumaView& luma = frame.luma;
  const auto take_row = luma.bytes_per_sample() == 1 ? &LampSamples::take<std::uint8_t>
                                                     : &LampSamples::take<std::uint16_t>;
  clear_count_ = clipped_count_ = 0;
  // Beside others, its own image on a wet road say, wings tell whose light is whose.
  const bool alone = guesses.size() == 1 && others_in.empty();
  const double most_wing_px = alone ? frame.most_lone_wing_px : kMostWingPixels;
  for (std::size_t i = 0; i < guesses.size(); ++i) {
    const double reach2 = square_of(reach_px[i]), rim = guesses[i].rim_px;
    const Eigen::Vector2d& centre = guesses[i].centre_px;
    const double dense = rim > 0.0 ? rim + kRimOutside_px : kDenseSizes * guesses[i].size_px;
    const double dense2 = square_of(dense);
    const double softened_px2 = frame.coding && rim == 0.0 ? frame.coding->softened_px2 : 0.0;
    const int stride =
        stride_of(kPi * (reach2 - dense2), rim > 0.0 ? most_wing_px : kMostUnclippedPixels);
    const int rim_stride =
        stride_of(2.0 * kPi * rim * (kRimInside_px + kRimOutside_px), kMostRimPixels);
    const std::size_t first_clear = clear_count_, first_clipped = clipped_count_;
    const Range rows(centre.y() - reach_px[i], centre.y() + reach_px[i], luma.height_px);
    for (int v = rows.first; v <= rows.last; ++v) {
      const double dv2 = square_of(std::abs(v - centre.y()));
      list_circles(i, v, guesses, reach_px, others_in);
      const auto take = [&](int first, int last, int every) {
        (this->*take_row)(frame, v, {first, last}, every, softened_px2);
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
    const Eigen::Vector2f from_origin_px = (centre - origin_px).cast<float>();
    set_places(*this, {first_clear, clear_count_}, from_origin_px, reach_px[i]);
    set_places(clipped_, {first_clipped, clipped_count_}, from_origin_px, reach_px[i]);
    if (frame.coding && rim > 0.0 && frame.coding->rim_factor > 1.0)
      weigh_rim(*this, {first_clear, clear_count_}, reach_px[i], rim, frame.coding->rim_factor);
  }
  used = clear_count_ + clipped_count_;
  clear = in_batches(clear_count_);
  resize(clear + in_batches(clipped_count_));
  for (const auto row : {&PixelRows::u_px, &PixelRows::v_px, &PixelRows::light, &PixelRows::place2,
                         &PixelRows::keep}) {
    std::vector<float>& all = this->*row;
    const auto begin = all.begin() + static_cast<std::ptrdiff_t>(clear);
    std::fill(all.begin() + static_cast<std::ptrdiff_t>(clear_count_), begin, 0.0F);
    const auto clipped = (clipped_.*row).begin();
    std::fill(std::copy(clipped, clipped + static_cast<std::ptrdiff_t>(clipped_count_), begin),
              all.end(), 0.0F);
  }
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
