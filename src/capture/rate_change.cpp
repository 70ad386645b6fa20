#include "capture/rate_change.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace vildar {
namespace {

constexpr double kBand = 1.1;  // frames: an event is at the first whole one after its time

/// Events at the first frames not before offset + period * number, for whole numbers.
struct Series {
  double period = 0.0, offset = 0.0;
  double told_nat = -INFINITY;  ///< ln of how much likelier than events anywhere
};

// Least squares, each event being that nearest to where one is expected.
Series fitted(std::span<const std::int64_t> frames, double period) {
  constexpr int kRounds = 4;
  const auto origin = static_cast<double>(frames.front());
  Series found{period, 0.0};
  double middle = 0.0;
  for (int round = 0; round < kRounds; ++round) {
    double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, number = 0.0;
    double before = 0.0;
    for (const std::int64_t frame : frames) {
      const double past = static_cast<double>(frame) - origin;
      // From one to the next: far from the first the period's error would add up.
      number = round == 0 ? number + std::round((past - before) / found.period)
                          : std::round((past - middle) / found.period);
      before = past;
      n += 1.0;
      x += number;
      y += past;
      xx += number * number;
      xy += number * past;
    }
    const double determinant = n * xx - x * x;
    if (!(determinant > 0.0)) return found;
    found.period = (n * xy - x * y) / determinant;
    middle = (y - found.period * x) / n;
    if (!(found.period > kBand)) return found;
  }
  double low = 0.5 * kBand, high = -0.5 * kBand, last = -INFINITY;
  int inside = 0, outside = 0;
  for (const std::int64_t frame : frames) {
    const double past = static_cast<double>(frame) - origin - middle;
    const double number = std::round(past / found.period), off = past - found.period * number;
    if (std::abs(off) > 0.5 * kBand || number == last) {
      ++outside;
      continue;
    }
    ++inside;
    last = number;
    low = std::min(low, off);
    high = std::max(high, off);
  }
  // All events within are at their first frames from anywhere between high - 1 and low on.
  found.offset = origin + middle + 0.5 * (low + high - 1.0);
  constexpr double kOutside = 0.03;  // share of events that are told wrongly
  const double anywhere = kBand / found.period;
  found.told_nat = inside * std::log((1.0 - kOutside) / anywhere) +
                   outside * std::log(kOutside / (1.0 - anywhere));
  return found;
}

// The frequency, up to a half, at which the first events recur most; the lowest of its multiples.
double strongest_per_frame(std::span<const std::int64_t> frames) {
  constexpr std::int64_t kSpan = 1500;
  constexpr double kFinest = 0.2;  // of what the span tells apart
  constexpr double kClear = 1.1;
  const auto end = std::ranges::upper_bound(frames, frames.front() + kSpan);
  const auto first = frames.first(static_cast<std::size_t>(end - frames.begin()));
  const auto span = static_cast<double>(std::max<std::int64_t>(first.back() - first.front(), 2));
  double best = 0.5, most = -1.0;
  for (double per_frame = 1.0 / span; per_frame <= 0.5; per_frame += kFinest / span) {
    std::complex<double> sum;
    for (const std::int64_t frame : first)
      sum += std::polar(1.0, 2.0 * std::numbers::pi * per_frame * static_cast<double>(frame));
    if (std::norm(sum) <= kClear * most) continue;
    most = std::norm(sum);
    best = per_frame;
  }
  return best;
}

}  // namespace

std::optional<RateChange> RateChange::by_events(std::span<const std::int64_t> frames, double more) {
  constexpr std::size_t kFewest = 8;
  constexpr double kNoChance_nat = 18.0;
  if (frames.size() < kFewest) return std::nullopt;
  const double mean =
      static_cast<double>(frames.back() - frames.front()) / static_cast<double>(frames.size() - 1);
  const double per_frame = strongest_per_frame(frames);
  Series best;
  // Whole frames recur at a frequency as they do at one less it.
  for (const double period : {mean, 1.0 / per_frame, 1.0 / (1.0 - per_frame)})
    if (const Series other = fitted(frames, period); other.told_nat > best.told_nat) best = other;
  if (!(best.told_nat > kNoChance_nat)) return std::nullopt;
  return RateChange(best.period, best.offset, more);
}

std::optional<RateChange> RateChange::by_repeats(std::span<const std::int64_t> frames) {
  return by_events(frames, -1.0);
}

std::optional<RateChange> RateChange::by_gaps(std::span<const std::int64_t> frames) {
  return by_events(frames, 1.0);
}

double RateChange::taken_at(std::int64_t frame) const {
  const double past = (static_cast<double>(frame) - first_) / period_;
  // Half an event is what the clock has gained on average beside whole ones.
  const double gained = std::floor(past) - (past - 0.5);
  return static_cast<double>(frame) + more_ * gained / rate_factor();
}

}  // namespace vildar
