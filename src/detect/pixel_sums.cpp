#include "detect/pixel_sums.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "detect/residual_shape.h"
#include "optics/disc_image.h"

// Highway compiles this file once per instruction set and picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detect/pixel_sums.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace vildar {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<float, DiscImage::kBatch>;
using Lanes = hn::Vec<Tag>;

double total(Lanes lanes) { return static_cast<double>(hn::GetLane(hn::SumOfLanes(Tag(), lanes))); }

void set_rows_here(std::span<const PixelRow> rows, std::span<const float> factors, PixelRow base,
                   std::span<float> sum) {
  const Tag tag;
  for (std::size_t i = 0; i < sum.size(); i += hn::Lanes(tag)) {
    Lanes here = base.empty() ? hn::Zero(tag) : hn::LoadU(tag, &base[i]);
    for (std::size_t row = 0; row < rows.size(); ++row)
      here = hn::MulAdd(hn::Set(tag, factors[row]), hn::LoadU(tag, &rows[row][i]), here);
    hn::StoreU(here, tag, &sum[i]);
  }
}

void set_forms_here(std::span<const PixelRow> rows, std::span<const float> root,
                    std::span<float> forms) {
  const Tag tag;
  for (std::size_t i = 0; i < forms.size(); i += hn::Lanes(tag)) {
    Lanes form = hn::Zero(tag);
    const float* factor = root.data();
    for (std::size_t first = 0; first < rows.size(); ++first) {
      Lanes along = hn::Zero(tag);
      for (std::size_t row = first; row < rows.size(); ++row)
        along = hn::MulAdd(hn::Set(tag, *factor++), hn::LoadU(tag, &rows[row][i]), along);
      form = hn::MulAdd(along, along, form);
    }
    hn::StoreU(form, tag, &forms[i]);
  }
}

/// Four rows at a time, so that no sum waits for the one before it.
void sum_products_here(std::span<const PixelRow> rows, PixelRow factor, std::span<double> sums) {
  const Tag tag;
  for (std::size_t first = 0; first < rows.size(); first += 4) {
    const float* row[4];
    for (std::size_t k = 0; k < 4; ++k) row[k] = rows[std::min(first + k, rows.size() - 1)].data();
    Lanes a = hn::Zero(tag), b = a, c = a, d = a;
    for (std::size_t i = 0; i < factor.size(); i += hn::Lanes(tag)) {
      const Lanes by = hn::LoadU(tag, &factor[i]);
      a = hn::MulAdd(by, hn::LoadU(tag, row[0] + i), a);
      b = hn::MulAdd(by, hn::LoadU(tag, row[1] + i), b);
      c = hn::MulAdd(by, hn::LoadU(tag, row[2] + i), c);
      d = hn::MulAdd(by, hn::LoadU(tag, row[3] + i), d);
    }
    const double of[4] = {total(a), total(b), total(c), total(d)};
    for (std::size_t k = 0; k < 4 && first + k < rows.size(); ++k) sums[first + k] = of[k];
  }
}

/// Two rows by four at a time: each number that is loaded takes part in several sums.
void sum_squares_here(std::span<const PixelRow> rows, PixelRow weight, std::span<double> sums) {
  const Tag tag;
  const std::size_t n = rows.size();
  for (std::size_t i = 0; i < n; i += 2) {
    const float* mine[2] = {rows[i].data(), rows[std::min(i + 1, n - 1)].data()};
    for (std::size_t first = 0; first <= std::min(i + 1, n - 1); first += 4) {
      const float* row[4];
      for (std::size_t k = 0; k < 4; ++k) row[k] = rows[std::min(first + k, n - 1)].data();
      Lanes a = hn::Zero(tag), b = a, c = a, d = a, e = a, f = a, g = a, h = a;
      for (std::size_t k = 0; k < weight.size(); k += hn::Lanes(tag)) {
        const Lanes by = hn::LoadU(tag, &weight[k]);
        const Lanes one = hn::Mul(by, hn::LoadU(tag, mine[0] + k));
        const Lanes two = hn::Mul(by, hn::LoadU(tag, mine[1] + k));
        const Lanes p = hn::LoadU(tag, row[0] + k), q = hn::LoadU(tag, row[1] + k);
        const Lanes r = hn::LoadU(tag, row[2] + k), s = hn::LoadU(tag, row[3] + k);
        a = hn::MulAdd(one, p, a);
        b = hn::MulAdd(one, q, b);
        c = hn::MulAdd(one, r, c);
        d = hn::MulAdd(one, s, d);
        e = hn::MulAdd(two, p, e);
        f = hn::MulAdd(two, q, f);
        g = hn::MulAdd(two, r, g);
        h = hn::MulAdd(two, s, h);
      }
      const double of[2][4] = {{total(a), total(b), total(c), total(d)},
                               {total(e), total(f), total(g), total(h)}};
      for (std::size_t m = 0; m < 2 && i + m < n; ++m)
        for (std::size_t k = 0; k < 4 && first + k <= i + m; ++k)
          sums[(i + m) * (i + m + 1) / 2 + first + k] = of[m][k];
    }
  }
}

void set_places_here(PixelRow u_px, PixelRow v_px, PixelRow keep, std::span<const LampRings> lamps,
                     std::span<std::int32_t> places) {
  const Tag tag;
  const hn::RebindToSigned<Tag> whole;
  const Lanes zero = hn::Zero(tag);
  const auto count = [](int value) HWY_ATTR { return hn::Set(hn::RebindToSigned<Tag>(), value); };
  const int per_lamp = ResidualShape::kRings * ResidualShape::kQuarters;
  for (std::size_t i = 0; i < places.size(); i += hn::Lanes(tag)) {
    auto place = count(0);
    Lanes least = hn::Set(tag, std::numeric_limits<float>::infinity());
    for (std::size_t lamp = 0; lamp < lamps.size(); ++lamp) {
      const LampRings& rings = lamps[lamp];
      const Lanes du = hn::Sub(hn::LoadU(tag, &u_px[i]), hn::Set(tag, rings.u_px));
      const Lanes dv = hn::Sub(hn::LoadU(tag, &v_px[i]), hn::Set(tag, rings.v_px));
      const Lanes away_px = hn::Sqrt(hn::MulAdd(du, du, hn::Mul(dv, dv)));
      const Lanes ring = hn::Mul(hn::Max(hn::Sub(away_px, hn::Set(tag, rings.inner_px)), zero),
                                 hn::Set(tag, rings.per_px));
      const auto in = hn::Min(hn::ConvertTo(whole, ring), count(ResidualShape::kRings - 1));
      const auto right = hn::RebindMask(whole, hn::Gt(hn::Add(du, dv), zero));
      const auto above = hn::RebindMask(whole, hn::Gt(hn::Sub(du, dv), zero));
      const auto quarter =
          hn::Add(hn::IfThenElseZero(right, count(1)), hn::IfThenElseZero(above, count(2)));
      const auto here = hn::Add(hn::Add(hn::Mul(in, count(ResidualShape::kQuarters)), quarter),
                                count(per_lamp * static_cast<int>(lamp)));
      place = hn::IfThenElse(hn::RebindMask(whole, hn::Le(ring, least)), here, place);
      least = hn::Min(least, ring);
    }
    const auto left_out = hn::RebindMask(whole, hn::Eq(hn::LoadU(tag, &keep[i]), zero));
    place = hn::IfThenElse(left_out, count(per_lamp * static_cast<int>(lamps.size())), place);
    hn::StoreU(place, whole, &places[i]);
  }
}

WeighedCosts weigh_here(const WeighedRows& rows, const PixelNoise& noise, double patch_variance) {
  const Tag tag;
  const hn::RebindToSigned<Tag> whole;
  const auto set = [](double value) HWY_ATTR { return hn::Set(Tag(), static_cast<float>(value)); };
  const Lanes zero = hn::Zero(tag), one = set(1.0);
  const Lanes dark = set(noise.dark_variance), per_light = set(1.0 / noise.electrons);
  const Lanes steps = set(static_cast<double>(noise.rounding.size() - 1));
  Lanes own = zero, frozen = zero;
  for (std::size_t i = 0; i < rows.light.size(); i += hn::Lanes(tag)) {
    const Lanes expected = hn::LoadU(tag, &rows.expected[i]);
    const Lanes light = hn::Max(expected, zero);
    const auto step = hn::ConvertTo(whole, hn::MulAdd(hn::Min(light, one), steps, set(0.5)));
    const Lanes own_noise = hn::Add(hn::MulAdd(light, per_light, dark),
                                    hn::GatherIndex(tag, noise.rounding.data(), step));
    const Lanes backdrop = hn::Max(hn::LoadU(tag, &rows.backdrop[i]), zero);
    const Lanes variance = hn::MulAdd(hn::Mul(set(patch_variance), backdrop), backdrop, own_noise);
    const Lanes weight = hn::Div(hn::LoadU(tag, &rows.keep[i]), variance);
    const Lanes residual = hn::Sub(hn::LoadU(tag, &rows.light[i]), expected);
    const Lanes pull = hn::Mul(residual, weight);
    own = hn::MulAdd(residual, pull, own);
    frozen =
        hn::MulAdd(hn::Mul(residual, residual), hn::LoadU(tag, &rows.weight_before[i]), frozen);
    hn::StoreU(residual, tag, &rows.residual[i]);
    hn::StoreU(weight, tag, &rows.weight[i]);
    hn::StoreU(pull, tag, &rows.pull[i]);
    hn::StoreU(hn::Div(own_noise, variance), tag, &rows.noise_share[i]);
  }
  return {total(own), total(frozen)};
}

}  // namespace HWY_NAMESPACE
}  // namespace vildar
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vildar {
namespace {

HWY_EXPORT(set_rows_here);
HWY_EXPORT(set_forms_here);
HWY_EXPORT(sum_products_here);
HWY_EXPORT(sum_squares_here);
HWY_EXPORT(set_places_here);
HWY_EXPORT(weigh_here);

}  // namespace

void set_rows(std::span<const PixelRow> rows, std::span<const float> factors, PixelRow base,
              std::span<float> sum) {
  HWY_DYNAMIC_DISPATCH(set_rows_here)(rows, factors, base, sum);
}

void set_forms(std::span<const PixelRow> rows, std::span<const float> root,
               std::span<float> forms) {
  HWY_DYNAMIC_DISPATCH(set_forms_here)(rows, root, forms);
}

void sum_products(std::span<const PixelRow> rows, PixelRow factor, std::span<double> sums) {
  HWY_DYNAMIC_DISPATCH(sum_products_here)(rows, factor, sums);
}

void sum_squares(std::span<const PixelRow> rows, PixelRow weight, std::span<double> sums) {
  HWY_DYNAMIC_DISPATCH(sum_squares_here)(rows, weight, sums);
}

void set_places(PixelRow u_px, PixelRow v_px, PixelRow keep, std::span<const LampRings> lamps,
                std::span<std::int32_t> places) {
  HWY_DYNAMIC_DISPATCH(set_places_here)(u_px, v_px, keep, lamps, places);
}

WeighedCosts weigh(const WeighedRows& rows, const PixelNoise& noise, double patch_variance) {
  return HWY_DYNAMIC_DISPATCH(weigh_here)(rows, noise, patch_variance);
}

}  // namespace vildar
#endif  // HWY_ONCE
