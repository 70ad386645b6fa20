#include <stdexcept>

#include "optics/disc_image.h"

// Highway compiles this file once per instruction set and picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "optics/disc_pixels.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#ifndef VILDAR_DISC_PROFILE
#define VILDAR_DISC_PROFILE
namespace vildar {

/// DiscImage's tables for the radius in force, and where the disc and its pixels are.
struct DiscProfile {
  const float *round, *round_slope, *square, *square_slope;
  int last_node;  // that has two after it
  float reach_px, nodes_per_px;
  const float *wing, *wing_slope;
  float wing_steps, unit_px, wing_share;
  const float *u, *v;
  std::size_t count;
  float centre_u, centre_v, weight;
};

/// Null but for `share` where the rest is not asked for; with `fresh` in place of what was there.
struct DiscSums {
  float *share, *per_u = nullptr, *per_v = nullptr, *per_radius = nullptr, *per_wing = nullptr;
  bool fresh = false;
};

}  // namespace vildar
#endif

HWY_BEFORE_NAMESPACE();
namespace vildar {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<float, 8>;
using Lanes = hn::Vec<Tag>;
using Indices = hn::Vec<hn::RebindToSigned<Tag>>;

/// Where in tables of the same steps the numbers about each pixel begin.
struct Places {
#if HWY_HAVE_SCALABLE || HWY_TARGET == HWY_SCALAR
  Indices at;
  explicit HWY_INLINE Places(Indices places) : at(places) {}
#else
  HWY_ALIGN std::int32_t at[hn::MaxLanes(Tag())];
  explicit HWY_INLINE Places(Indices places) { hn::Store(places, hn::RebindToSigned<Tag>(), at); }
#endif
};

#if !HWY_HAVE_SCALABLE && HWY_TARGET != HWY_SCALAR
/// Four numbers from each place, in a block each.
template <class D>
HWY_INLINE hn::Vec<D> load_blocks(D tag, const float* from, const std::int32_t* places) {
  const hn::FixedTag<float, 4> block;
  if constexpr (hn::MaxLanes(D()) == 4)
    return hn::LoadU(block, from + places[0]);
  else
    return hn::Combine(tag, hn::LoadU(block, from + places[4]), hn::LoadU(block, from + places[0]));
}
#endif

/// The number at each place, the one after it ...
HWY_INLINE void load_four(const float* from, const Places& places, Lanes& a, Lanes& b, Lanes& c,
                          Lanes& d) {
  const Tag tag;
#if HWY_HAVE_SCALABLE || HWY_TARGET == HWY_SCALAR
  a = hn::GatherIndex(tag, from, places.at);
  b = hn::GatherIndex(tag, from + 1, places.at);
  c = hn::GatherIndex(tag, from + 2, places.at);
  d = hn::GatherIndex(tag, from + 3, places.at);
#else
  // Cheaper than to gather: one load for each place, and a transposition.
  const std::int32_t* const at = places.at;
  const Lanes first = load_blocks(tag, from, at), second = load_blocks(tag, from, at + 1);
  const Lanes third = load_blocks(tag, from, at + 2), fourth = load_blocks(tag, from, at + 3);
  const Lanes low_even = hn::InterleaveLower(tag, first, third);
  const Lanes low_odd = hn::InterleaveLower(tag, second, fourth);
  const Lanes high_even = hn::InterleaveUpper(tag, first, third);
  const Lanes high_odd = hn::InterleaveUpper(tag, second, fourth);
  a = hn::InterleaveLower(tag, low_even, low_odd);
  b = hn::InterleaveUpper(tag, low_even, low_odd);
  c = hn::InterleaveLower(tag, high_even, high_odd);
  d = hn::InterleaveUpper(tag, high_even, high_odd);
#endif
}

// Four-point Lagrange interpolation, as in disc_image.cpp. Inline, so that what tables share at one
// t is worked out once.
HWY_INLINE Lanes value_at(Lanes t, Lanes a, Lanes b, Lanes c, Lanes d) {
  const Tag tag;
  const Lanes before = hn::Sub(t, hn::Set(tag, 1.0F)), beyond = hn::Sub(t, hn::Set(tag, 2.0F));
  const Lanes after = hn::Add(t, hn::Set(tag, 1.0F));
  const Lanes outer = hn::Mul(before, hn::Mul(t, hn::Set(tag, 1.0F / 6.0F)));
  const Lanes inner = hn::Mul(after, hn::Mul(beyond, hn::Set(tag, 0.5F)));
  const Lanes near = hn::NegMulAdd(hn::Mul(inner, t), c, hn::Mul(hn::Mul(inner, before), b));
  const Lanes off = hn::NegMulAdd(hn::Mul(outer, beyond), a, hn::Mul(hn::Mul(outer, after), d));
  return hn::Add(near, off);
}

HWY_INLINE Lanes value_of(const float* nodes, const Places& first, Lanes t) {
  Lanes a, b, c, d;
  load_four(nodes, first, a, b, c, d);
  return value_at(t, a, b, c, d);
}

/// Value, and slope by t.
HWY_INLINE Lanes value_of(const float* nodes, const Places& first, Lanes t, Lanes& slope) {
  const Tag tag;
  Lanes a, b, c, d;
  load_four(nodes, first, a, b, c, d);
  const auto quadratic = [&](float x, float y, float z) HWY_ATTR {
    return hn::MulAdd(t, hn::MulAdd(t, hn::Set(tag, x), hn::Set(tag, y)), hn::Set(tag, z));
  };
  slope = hn::Mul(a, quadratic(-0.5F, 1.0F, -1.0F / 3.0F));
  slope = hn::MulAdd(b, quadratic(1.5F, -2.0F, -0.5F), slope);
  slope = hn::MulAdd(c, quadratic(-1.5F, 1.0F, 1.0F), slope);
  slope = hn::MulAdd(d, quadratic(0.5F, 0.0F, -1.0F / 6.0F), slope);
  return value_at(t, a, b, c, d);
}

template <bool kSlopes, bool kFresh>
void add_disc(const DiscProfile& disc, const DiscSums& sums) {
  const Tag tag;
  const hn::RebindToSigned<Tag> whole;
  const auto set = [](float value) HWY_ATTR { return hn::Set(Tag(), value); };
  const auto add = [&](float* sum, std::size_t i, Lanes value) HWY_ATTR {
    const Lanes before = kFresh ? hn::Zero(Tag()) : hn::LoadU(Tag(), sum + i);
    hn::StoreU(hn::MulAdd(value, hn::Set(Tag(), disc.weight), before), Tag(), sum + i);
  };
  for (std::size_t i = 0; i < disc.count; i += hn::Lanes(tag)) {
    const Lanes du = hn::Sub(hn::LoadU(tag, disc.u + i), set(disc.centre_u));
    const Lanes dv = hn::Sub(hn::LoadU(tag, disc.v + i), set(disc.centre_v));
    const Lanes r = hn::Sqrt(hn::MulAdd(du, du, hn::Mul(dv, dv)));
    const Lanes inverse_r = hn::Div(set(1.0F), hn::Max(r, set(1e-6F)));
    const Lanes cosine = hn::Mul(du, inverse_r), sine = hn::Mul(dv, inverse_r);

    const Lanes inverse_far = hn::Div(set(1.0F), hn::Add(r, set(disc.unit_px)));
    const Lanes far = hn::Mul(hn::Mul(r, inverse_far), set(disc.wing_steps));
    const Indices far_node = hn::ConvertTo(whole, far);
    const Lanes far_t = hn::Sub(far, hn::ConvertTo(tag, far_node));
    const Places far_places(far_node);
    Lanes by_step;
    const Lanes wing = value_of(disc.wing, far_places, far_t, by_step);
    Lanes share = hn::Mul(wing, set(disc.wing_share)), per_wing = wing;
    Lanes per_radius = hn::Zero(tag), per_r = hn::Zero(tag);
    Lanes per_u = hn::Zero(tag), per_v = hn::Zero(tag);
    if constexpr (kSlopes) {
      const Lanes wing_r = hn::Mul(
          by_step, hn::Mul(set(disc.wing_steps * disc.unit_px), hn::Mul(inverse_far, inverse_far)));
      const Lanes wing_radius = hn::NegMulAdd(wing_r, hn::Mul(r, set(1.0F / disc.unit_px)),
                                              value_of(disc.wing_slope, far_places, far_t));
      per_radius = hn::Mul(wing_radius, set(disc.wing_share));
      per_r = hn::Mul(wing_r, set(disc.wing_share));
    }
    const auto inside = hn::Lt(r, set(disc.reach_px));
    if (!hn::AllFalse(tag, inside)) {
      const Lanes weight = hn::IfThenElseZero(inside, set(1.0F - disc.wing_share));
      const Lanes place = hn::Mul(r, set(disc.nodes_per_px));
      const Indices node = hn::Min(hn::ConvertTo(whole, place), hn::Set(whole, disc.last_node));
      const Lanes t = hn::Sub(place, hn::ConvertTo(tag, node));
      // cos(4 angle) = 1 - 8 cos^2 sin^2.
      const Lanes c2 = hn::Mul(cosine, cosine), s2 = hn::Mul(sine, sine);
      const Lanes four = hn::NegMulAdd(hn::Mul(set(8.0F), c2), s2, set(1.0F));
      const Places places(node);
      Lanes round_by_step, square_by_step;
      const Lanes square = value_of(disc.square, places, t, square_by_step);
      const Lanes round = value_of(disc.round, places, t, round_by_step);
      const Lanes core = hn::MulAdd(square, four, round);
      share = hn::MulAdd(weight, core, share);
      if constexpr (kSlopes) {
        per_wing = hn::Sub(per_wing, hn::IfThenElseZero(inside, core));
        per_radius = hn::MulAdd(weight,
                                hn::MulAdd(value_of(disc.square_slope, places, t), four,
                                           value_of(disc.round_slope, places, t)),
                                per_radius);
        per_r = hn::MulAdd(hn::Mul(weight, set(disc.nodes_per_px)),
                           hn::MulAdd(square_by_step, four, round_by_step), per_r);
        const Lanes turn = hn::Mul(hn::Mul(hn::Mul(weight, set(16.0F)), hn::Mul(square, inverse_r)),
                                   hn::Mul(hn::Mul(cosine, sine), hn::Sub(s2, c2)));
        per_u = hn::Mul(turn, sine);
        per_v = hn::Neg(hn::Mul(turn, cosine));
      }
    }
    add(sums.share, i, share);
    if constexpr (kSlopes) {
      // The pixel stays, the disc moves.
      add(sums.per_u, i, hn::NegMulAdd(per_r, cosine, per_u));
      add(sums.per_v, i, hn::NegMulAdd(per_r, sine, per_v));
      add(sums.per_radius, i, per_radius);
      add(sums.per_wing, i, per_wing);
    }
  }
}

void add_disc_here(const DiscProfile& disc, const DiscSums& sums) {
  if (sums.per_u == nullptr)
    add_disc<false, false>(disc, sums);
  else if (sums.fresh)
    add_disc<true, true>(disc, sums);
  else
    add_disc<true, false>(disc, sums);
}

}  // namespace HWY_NAMESPACE
}  // namespace vildar
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vildar {
namespace {

HWY_EXPORT(add_disc_here);

DiscSums sums_of(DiscImage::Pixels& pixels, bool fresh) {
  return {pixels.share.data(),      pixels.per_u.data(),          pixels.per_v.data(),
          pixels.per_radius.data(), pixels.per_wing_share.data(), fresh};
}

void check(std::size_t sums, std::size_t u, std::size_t v) {
  if (u != v || sums != u || u % DiscImage::kBatch != 0)
    throw std::invalid_argument("DiscImage: pixels must come in equal numbers, in batches of 16");
}

}  // namespace

DiscProfile DiscImage::profile(std::span<const float> u_px, std::span<const float> v_px,
                               const Eigen::Vector2d& centre_px, double weight) const {
  const auto single = [](double value) { return static_cast<float>(value); };
  return {core_.round.data(),
          core_.round_slope.data(),
          core_.square.data(),
          core_.square_slope.data(),
          static_cast<int>(core_.round.size()) - 4,
          single(core_reach_px_),
          single(1.0 / step_px_),
          wing_.data(),
          wing_slope_.data(),
          kWingSteps,
          single(unit_px_),
          single(shape_.wing_share),
          u_px.data(),
          v_px.data(),
          u_px.size(),
          single(centre_px.x()),
          single(centre_px.y()),
          single(weight)};
}

void DiscImage::add_to(Pixels& sum, std::span<const float> u_px, std::span<const float> v_px,
                       const Eigen::Vector2d& centre_px, double weight) const {
  check(sum.share.size(), u_px.size(), v_px.size());
  HWY_DYNAMIC_DISPATCH(add_disc_here)(profile(u_px, v_px, centre_px, weight), sums_of(sum, false));
}

void DiscImage::set_to(Pixels& pixels, std::span<const float> u_px, std::span<const float> v_px,
                       const Eigen::Vector2d& centre_px, double weight) const {
  for (std::vector<float>* one :
       {&pixels.share, &pixels.per_u, &pixels.per_v, &pixels.per_radius, &pixels.per_wing_share})
    one->resize(u_px.size());
  check(u_px.size(), u_px.size(), v_px.size());
  HWY_DYNAMIC_DISPATCH(add_disc_here)
  (profile(u_px, v_px, centre_px, weight), sums_of(pixels, true));
}

void DiscImage::add_to(std::vector<float>& share, std::span<const float> u_px,
                       std::span<const float> v_px, const Eigen::Vector2d& centre_px,
                       double weight) const {
  check(share.size(), u_px.size(), v_px.size());
  HWY_DYNAMIC_DISPATCH(add_disc_here)(profile(u_px, v_px, centre_px, weight), {share.data()});
}

}  // namespace vildar
#endif  // HWY_ONCE
