#pragma once

#include <array>
#include <span>

#include <Eigen/Core>

#include "optics/ego_trace.h"
#include "types/site.h"

namespace vildar {

/// Standard deviation of the noise of yaw rates from sample to sample, by their fourth differences;
/// 0 of less than five.
double yaw_rate_noise_rad_per_s(std::span<const EgoSample> samples);

/// What yaw rates leave open of the heading while another vehicle is watched: a bias that stays,
/// and the walk that the sum of their noise is, by the first of its Karhunen-Loeve expansion.
class YawRateErrors {
 public:
  static constexpr int kCount = 7;
  using Values = Eigen::Array<double, kCount, 1>;

  YawRateErrors(const EgoSite& site, const TimeSpan& watched);

  /// Of the errors by which the curves below are multiplied: rad/s of the bias, rad of the walk.
  const std::array<Uncertain, kCount>& errors() const { return errors_; }
  /// Before and after the time in which it is watched the walk stays as at its ends.
  Values heading_at(double time_s) const;
  /// The headings' integral over time, from where the watch begins.
  Values way_s(double time_s) const;

 private:
  double rate_of(int walk) const;

  TimeSpan watched_;
  std::array<Uncertain, kCount> errors_{};
};

}  // namespace vildar
