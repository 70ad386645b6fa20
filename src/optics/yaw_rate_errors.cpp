#include "optics/yaw_rate_errors.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "core/quantity.h"

namespace vildar {
namespace {

// What a gyroscope that was set to zero at a halt is taken to drift by, 0.1 degrees per second.
constexpr double kBias_rad_per_s = 0.002;
// Less moves no lamp by more than a hundredth of a pixel or two.
constexpr double kToldWalk_rad = 8e-6;

}  // namespace

double yaw_rate_noise_rad_per_s(std::span<const EgoSample> samples) {
  std::vector<double> rates_rad_per_s;
  std::ranges::transform(samples, std::back_inserter(rates_rad_per_s),
                         &EgoSample::yaw_rate_rad_per_s);
  return trace_noise(rates_rad_per_s);
}

YawRateErrors::YawRateErrors(const EgoSite& site, const TimeSpan& watched) : watched_(watched) {
  errors_[0].std = kBias_rad_per_s;
  const auto from = std::ranges::lower_bound(site.trace, watched.from_s, {}, &EgoSample::time_s);
  const auto to = std::ranges::upper_bound(site.trace, watched.to_s, {}, &EgoSample::time_s);
  if (to - from < 2) return;
  const double step_s = ((to - 1)->time_s - from->time_s) / static_cast<double>(to - from - 1);
  const double walk_rad =
      yaw_rate_noise_rad_per_s({from, to}) * std::sqrt(step_s * (watched.to_s - watched.from_s));
  for (int walk = 0; walk + 1 < kCount; ++walk) {
    const double std_rad = walk_rad / ((walk + 0.5) * kPi);
    if (std_rad > kToldWalk_rad) errors_[static_cast<std::size_t>(walk) + 1].std = std_rad;
  }
}

double YawRateErrors::rate_of(int walk) const {
  return (walk + 0.5) * kPi / (watched_.to_s - watched_.from_s);
}

YawRateErrors::Values YawRateErrors::heading_at(double time_s) const {
  const double since_s = time_s - watched_.from_s;
  const double within_s = std::clamp(time_s, watched_.from_s, watched_.to_s) - watched_.from_s;
  Values heading;
  heading[0] = since_s;
  for (int walk = 0; walk + 1 < kCount; ++walk)
    heading[walk + 1] = std::sqrt(2.0) * std::sin(rate_of(walk) * within_s);
  return heading;
}

YawRateErrors::Values YawRateErrors::way_s(double time_s) const {
  const double since_s = time_s - watched_.from_s;
  const double within_s = std::clamp(time_s, watched_.from_s, watched_.to_s) - watched_.from_s;
  Values way = (since_s - within_s) * heading_at(time_s);
  way[0] = 0.5 * since_s * since_s;
  for (int walk = 0; walk + 1 < kCount; ++walk)
    way[walk + 1] += std::sqrt(2.0) * (1.0 - std::cos(rate_of(walk) * within_s)) / rate_of(walk);
  return way;
}

}  // namespace vildar
