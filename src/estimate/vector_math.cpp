#include "estimate/vector_math.h"

#include <cassert>

// Highway compiles this file once per instruction set and picks one at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "estimate/vector_math.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h

#include <hwy/highway.h>

#include <hwy/contrib/math/math-inl.h>  // needs highway.h

HWY_BEFORE_NAMESPACE();
namespace vildar {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class Function>
void each(const double* in, double* out, std::size_t count, Function function) {
  const hn::ScalableTag<double> tag;
  const std::size_t lanes = hn::Lanes(tag);
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes)
    hn::StoreU(function(tag, hn::LoadU(tag, in + i)), tag, out + i);
  const hn::CappedTag<double, 1> one;
  for (; i < count; ++i) hn::StoreU(function(one, hn::LoadU(one, in + i)), one, out + i);
}

void logs_here(const double* in, double* out, std::size_t count) {
  each(in, out, count, [](auto tag, auto value) HWY_ATTR { return hn::Log(tag, value); });
}

void exponentials_here(const double* in, double* out, std::size_t count) {
  each(in, out, count, [](auto tag, auto value) HWY_ATTR { return hn::Exp(tag, value); });
}

void arctangents_here(const double* in, double* out, std::size_t count) {
  each(in, out, count, [](auto tag, auto value) HWY_ATTR { return hn::Atan(tag, value); });
}

void sines_here(const double* in, double* out, std::size_t count) {
  each(in, out, count, [](auto tag, auto value) HWY_ATTR { return hn::Sin(tag, value); });
}

void cosines_here(const double* in, double* out, std::size_t count) {
  each(in, out, count, [](auto tag, auto value) HWY_ATTR { return hn::Cos(tag, value); });
}

}  // namespace HWY_NAMESPACE
}  // namespace vildar
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace vildar {
namespace {

HWY_EXPORT(logs_here);
HWY_EXPORT(exponentials_here);
HWY_EXPORT(arctangents_here);
HWY_EXPORT(sines_here);
HWY_EXPORT(cosines_here);

}  // namespace

void natural_logs(std::span<const double> in, std::span<double> out) {
  assert(in.size() == out.size());
  HWY_DYNAMIC_DISPATCH(logs_here)(in.data(), out.data(), in.size());
}

void exponentials(std::span<const double> in, std::span<double> out) {
  assert(in.size() == out.size());
  HWY_DYNAMIC_DISPATCH(exponentials_here)(in.data(), out.data(), in.size());
}

void arctangents(std::span<const double> in, std::span<double> out) {
  assert(in.size() == out.size());
  HWY_DYNAMIC_DISPATCH(arctangents_here)(in.data(), out.data(), in.size());
}

void sines(std::span<const double> in_rad, std::span<double> out) {
  assert(in_rad.size() == out.size());
  HWY_DYNAMIC_DISPATCH(sines_here)(in_rad.data(), out.data(), in_rad.size());
}

void cosines(std::span<const double> in_rad, std::span<double> out) {
  assert(in_rad.size() == out.size());
  HWY_DYNAMIC_DISPATCH(cosines_here)(in_rad.data(), out.data(), in_rad.size());
}

}  // namespace vildar
#endif  // HWY_ONCE
