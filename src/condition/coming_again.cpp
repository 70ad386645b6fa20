#include "condition/coming_again.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "condition/condition.h"

namespace vildar {
namespace {

// Means of even blocks, NaN where the trace has none, about a stretch of it.
class LightAbout {
 public:
  LightAbout(const PowerTrace& trace, double from_s, double to_s, double margin_s)
      : block_s_(std::max(kBlock_s, 2.0 * trace.sample_period_s)),
        blocks_(blocks_in(to_s - from_s)),
        margin_(blocks_in(margin_s)) {
    light_w_.assign(static_cast<std::size_t>(blocks_ + 2 * margin_), std::nan(""));
    const double first_s = from_s - static_cast<double>(margin_) * block_s_;
    const double end_s = first_s + static_cast<double>(light_w_.size()) * block_s_;
    for (const PowerBlock& block : block_means(trace, first_s, end_s, block_s_)) {
      const auto at =
          static_cast<std::size_t>(std::clamp(std::floor((block.time_s - first_s) / block_s_), 0.0,
                                              static_cast<double>(light_w_.size() - 1)));
      light_w_[at] = block.power_w;
      sigma_w_ = block.sigma_w;
    }
    variance_w2_ = variance_w2([&](int i) { return at(i); });
  }

  bool is_clear() const {
    constexpr double kTimesNoise = 5.0;
    return variance_w2_ > kTimesNoise * kTimesNoise * sigma_w_ * sigma_w_;
  }
  /// How unlike the stretch what comes so much later is, beside a steady difference: rms without
  /// the noise, of the stretch's own.
  double unlike(double after_s) const {
    const double blocks = after_s / block_s_, whole = std::floor(blocks);
    const double excess_w2 = variance_w2([&](int i) {
                               const int k = i + static_cast<int>(whole);
                               return std::lerp(at(k), at(k + 1), blocks - whole) - at(i);
                             }) -
                             2.0 * sigma_w_ * sigma_w_;
    return std::isnan(excess_w2) ? INFINITY : std::sqrt(std::max(0.0, excess_w2) / variance_w2_);
  }

 private:
  static constexpr double kBlock_s = 0.01;
  int blocks_in(double time_s) const { return static_cast<int>(std::ceil(time_s / block_s_)); }
  double at(int block) const {
    const int i = block + margin_;
    return i >= 0 && i < static_cast<int>(light_w_.size()) ? light_w_[static_cast<std::size_t>(i)]
                                                           : std::nan("");
  }
  // Of the stretch's blocks; NaN where too few of them have both.
  template <typename Of>
  double variance_w2(const Of& of) const {
    constexpr double kMostMissing = 0.1;
    double sum = 0.0, squares = 0.0, count = 0.0;
    for (int i = 0; i < blocks_; ++i) {
      const double value_w = of(i);
      if (std::isnan(value_w)) continue;
      sum += value_w;
      squares += value_w * value_w;
      ++count;
    }
    if (count < (1.0 - kMostMissing) * blocks_) return std::nan("");
    return squares / count - std::pow(sum / count, 2);
  }

  double block_s_;
  int blocks_, margin_;
  std::vector<double> light_w_;
  double sigma_w_ = 0.0, variance_w2_ = 0.0;
};

}  // namespace

std::optional<double> comes_again_after_s(const PowerTrace& trace, double from_s, double to_s) {
  constexpr double kShortest_s = 0.2, kLongest_s = 1.4, kStep_s = 0.0025;
  constexpr double kAlike = 0.15, kUnlike = 0.7;
  constexpr int kTimes = 4;
  if (!(to_s - from_s < 2.0 * kLongest_s)) return std::nullopt;
  const LightAbout light(trace, from_s, to_s, kTimes * kLongest_s);
  if (!light.is_clear()) return std::nullopt;
  for (const double way : {1.0, -1.0}) {
    bool changed = false;
    double before = INFINITY, once = light.unlike(way * kStep_s);
    for (int step = 1; step * kStep_s < kLongest_s; ++step) {
      const double after_s = step * kStep_s;
      const double next = light.unlike(way * (after_s + kStep_s));
      changed = changed || once > kUnlike;
      const bool comes_again =
          changed && after_s > kShortest_s && once < kAlike && once <= before && once <= next;
      before = std::exchange(once, next);
      if (!comes_again) continue;
      int times = 2;
      for (int k = 2; light.unlike(way * k * after_s) < kAlike; ++k) ++times;
      for (int k = 1; light.unlike(-way * k * after_s) < kAlike; ++k) ++times;
      if (times >= kTimes) return after_s;
    }
  }
  return std::nullopt;
}

}  // namespace vildar
