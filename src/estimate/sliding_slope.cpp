#include "estimate/sliding_slope.h"

#include <cmath>
#include <stdexcept>

namespace vildar {

SlidingPowerSlope::SlidingPowerSlope(const PowerLaw& law, Metres perpendicular,
                                     std::size_t window_samples)
    : log_gain_(std::log(law.gain_w)),
      exponent_(-2.0 / law.path_loss_exponent),
      perpendicular2_m2_(perpendicular.value() * perpendicular.value()),
      ring_(window_samples) {
  if (!(law.gain_w > 0.0 && law.path_loss_exponent > 0.0 && perpendicular.value() >= 0.0))
    throw std::domain_error("SlidingPowerSlope: K and gamma must be positive, d not negative");
  if (window_samples < 3)
    throw std::invalid_argument("SlidingPowerSlope: a window has three samples or more");
}

void SlidingPowerSlope::add(const Entry& entry, double sign) {
  if (!entry.used) return;
  const double t = entry.time_s - origin_s_, y = entry.range_m - origin_m_;
  count_ += sign;
  t_ += sign * t;
  y_ += sign * y;
  tt_ += sign * t * t;
  ty_ += sign * t * y;
}

// Once per window length: fresh sums about a fresh origin, so that rounding errors do not pile up.
void SlidingPowerSlope::rebase() {
  const Entry& newest = ring_[(next_ + ring_.size() - 1) % ring_.size()];
  origin_s_ = newest.time_s;
  origin_m_ = newest.used ? newest.range_m : origin_m_;
  count_ = t_ = y_ = tt_ = ty_ = 0.0;
  for (std::size_t i = 0; i < filled_; ++i) add(ring_[i], 1.0);
  since_rebase_ = 0;
}

void SlidingPowerSlope::push(double time_s, double power_w) {
  Entry entry{time_s, 0.0, false};
  if (power_w > 0.0 && std::isfinite(power_w) && std::isfinite(time_s)) {
    const double square_m2 =
        std::exp(exponent_ * (std::log(power_w) - log_gain_)) - perpendicular2_m2_;
    entry.used = square_m2 >= 0.0 && std::isfinite(square_m2);
    if (entry.used) entry.range_m = std::sqrt(square_m2);
  }
  if (filled_ == ring_.size())
    add(ring_[next_], -1.0);
  else
    ++filled_;
  ring_[next_] = entry;
  next_ = (next_ + 1) % ring_.size();
  add(entry, 1.0);
  if (++since_rebase_ >= ring_.size()) rebase();
}

std::optional<double> SlidingPowerSlope::speed_mps() const {
  if (filled_ < ring_.size() || count_ < 3.0) return std::nullopt;
  const double spread = tt_ - t_ * t_ / count_;
  if (!(spread > 1e-12 * tt_) || !(spread > 1e-24)) return std::nullopt;
  return -(ty_ - t_ * y_ / count_) / spread;
}

}  // namespace vildar
