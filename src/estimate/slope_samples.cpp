#include "estimate/slope_samples.h"

#include <cmath>
#include <limits>

// Highway compiles this file once per instruction set and picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "estimate/slope_samples.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h

#include <hwy/highway.h>

#include <hwy/contrib/math/math-inl.h>  // needs highway.h

#ifndef VILDAR_SLOPE_LAW
#define VILDAR_SLOPE_LAW
namespace vildar {

// distance^2 = exp(exponent ln P + log_factor), of which `perpendicular_m2` is across the road.
struct SlopeLaw {
  double exponent, log_factor, perpendicular_m2;
};

}  // namespace vildar
#endif

HWY_BEFORE_NAMESPACE();
namespace vildar {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// One vector of samples; kept ones are written one after the other. Returns how many are kept. What
// is written beyond them is of no meaning.
template <class Tag>
HWY_INLINE std::size_t keep_samples(Tag tag, const double* time_s, const double* power_w,
                                    const SlopeLaw& law, double* kept_s, double* along_m,
                                    std::size_t& lit_count) {
  const auto zero = hn::Zero(tag), most = hn::Set(tag, std::numeric_limits<double>::max());
  const auto t_s = hn::LoadU(tag, time_s), power = hn::LoadU(tag, power_w);
  const auto lit =
      hn::And(hn::And(hn::Gt(power, zero), hn::Le(power, most)), hn::Le(hn::Abs(t_s), most));
  const auto distance2 = hn::Exp(tag, hn::MulAdd(hn::Set(tag, law.exponent), hn::Log(tag, power),
                                                 hn::Set(tag, law.log_factor)));
  const auto along2 = hn::Sub(distance2, hn::Set(tag, law.perpendicular_m2));
  const auto inside = hn::And(lit, hn::And(hn::Ge(along2, zero), hn::Le(along2, most)));
  const std::size_t lanes = hn::Lanes(tag);
  hn::StoreU(t_s, tag, kept_s);
  hn::StoreU(hn::IfThenElse(inside, hn::Sqrt(along2), hn::Set(tag, -1.0)), tag, along_m);
  if (hn::AllTrue(tag, inside)) {
    lit_count += lanes;
    return lanes;
  }
  lit_count += hn::CountTrue(tag, lit);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < lanes; ++i) {
    kept_s[kept] = kept_s[i];
    along_m[kept] = along_m[i];
    kept += along_m[i] >= 0.0;
  }
  return kept;
}

// The buffers have room for a whole vector behind the last sample.
std::size_t slope_samples_here(std::span<const double> time_s, std::span<const double> power_w,
                               const SlopeLaw& law, double* kept_s, double* along_m,
                               std::size_t& lit) {
  const hn::ScalableTag<double> tag;
  const hn::CappedTag<double, 1> one;
  const std::size_t lanes = hn::Lanes(tag), count = time_s.size();
  std::size_t i = 0, kept = 0;
  for (; i + lanes <= count; i += lanes)
    kept += keep_samples(tag, &time_s[i], &power_w[i], law, kept_s + kept, along_m + kept, lit);
  for (; i < count; ++i)
    kept += keep_samples(one, &time_s[i], &power_w[i], law, kept_s + kept, along_m + kept, lit);
  return kept;
}

std::size_t lanes_here() { return hn::Lanes(hn::ScalableTag<double>()); }

}  // namespace HWY_NAMESPACE
}  // namespace vildar
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vildar {
namespace {

HWY_EXPORT(slope_samples_here);
HWY_EXPORT(lanes_here);

}  // namespace

SlopeSamples slope_samples(std::span<const double> time_s, std::span<const double> power_w,
                           double gain_w, double path_loss_exponent, double perpendicular_m) {
  const double exponent = -2.0 / path_loss_exponent;
  const SlopeLaw law{exponent, -exponent * std::log(gain_w), perpendicular_m * perpendicular_m};
  const std::size_t room = time_s.size() + HWY_DYNAMIC_DISPATCH(lanes_here)();
  SlopeSamples samples{std::vector<double>(room), std::vector<double>(room), 0};
  const std::size_t kept = HWY_DYNAMIC_DISPATCH(slope_samples_here)(
      time_s, power_w, law, samples.time_s.data(), samples.along_m.data(), samples.lit);
  samples.time_s.resize(kept);
  samples.along_m.resize(kept);
  return samples;
}

}  // namespace vildar
#endif  // HWY_ONCE
