#include "capture/frame_clock.h"

#include <algorithm>
#include <cmath>

namespace vildar {
namespace {

constexpr std::size_t kEarlyIntervals = 64;
constexpr std::size_t kIntervalsForRate = 10;
constexpr std::size_t kIntervalsForPeriod = 4;
constexpr std::chrono::nanoseconds kFar = std::chrono::seconds(10);
constexpr int kFarPeriods = 300;
/// Of a period: no camera takes frames so close; muxers move a repeated stamp by one tick.
constexpr int kRepeatShare = 200;

}  // namespace

FrameClock::FrameClock(Nanoseconds period)
    : period_(std::clamp(period, Nanoseconds(1), Nanoseconds(std::chrono::hours(1)))),
      far_(std::max(std::min(kFar, kFarPeriods * period_), 2 * period_)) {}

bool FrameClock::doubts(Stamp stamp) const {
  if (!anchored_) return false;
  if (!stamp) return true;
  const Nanoseconds at = *stamp - origin_;
  return at <= last_ + period() / kRepeatShare || at - last_ > far_;
}

FrameClock::Nanoseconds FrameClock::place(Stamp stamp, Stamp next) {
  if (!anchored_) {
    const Nanoseconds at = placed_ == 0 ? Nanoseconds(0) : last_ + period();
    if (!stamp) return repair(at);
    anchored_ = true;
    origin_ = *stamp - at;
    return accept(at);
  }
  if (!doubts(stamp)) return accept(*stamp - origin_);
  if (stamp) {
    const Nanoseconds at = *stamp - origin_;
    const bool carried_on = next && *next > *stamp && *next - *stamp <= far_;
    if (at > last_ + far_ && carried_on) return accept(at);
    if (at < last_ - far_ && carried_on) {
      const Nanoseconds resumed = last_ + period();
      origin_ = *stamp - resumed;
      return repair(resumed);
    }
  }
  Nanoseconds step = period();
  if (next) {
    const Nanoseconds room = *next - origin_ - last_;
    if (room > Nanoseconds(1) && room <= far_) step = std::min(step, room / 2);
  }
  return repair(last_ + step);
}

/// The stamps know their rate better than the header does.
FrameClock::Nanoseconds FrameClock::period() const {
  if (early_intervals_s_.size() < kIntervalsForPeriod) return period_;
  return std::max(Nanoseconds(1), Nanoseconds(std::llround(typical_interval_s() * 1e9)));
}

FrameClock::Nanoseconds FrameClock::repair(Nanoseconds at) {
  if (repaired_++ == 0) first_repaired_ = placed_;
  ++placed_;
  last_genuine_ = false;
  return last_ = at;
}

FrameClock::Nanoseconds FrameClock::accept(Nanoseconds at) {
  if (last_genuine_) note_interval(at - last_);
  ++placed_;
  last_genuine_ = true;
  return last_ = at;
}

void FrameClock::note_interval(Nanoseconds interval) {
  const double interval_s = static_cast<double>(interval.count()) * 1e-9;
  if (early_intervals_s_.size() < kEarlyIntervals)
    early_intervals_s_.push_back(interval_s);
  else
    later_.add(interval_s, typical_interval_s());
}

/// Mean of the intervals near the median: stamps rounded to milliseconds alternate, and their
/// median alone would be a per cent off.
double FrameClock::typical_interval_s() const {
  std::vector<double> sorted = early_intervals_s_;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  const double median_s = *middle;
  double sum_s = 0.0;
  int count = 0;
  for (const double interval_s : early_intervals_s_) {
    if (std::abs(interval_s - median_s) > 0.25 * median_s) continue;
    sum_s += interval_s;
    ++count;
  }
  return sum_s / count;
}

void FrameClock::Tally::add(double interval_s, double typical_s) {
  constexpr double kFit = 0.2;  // of a period: jitter of field recorders stays below
  ++intervals;
  const double periods = interval_s / typical_s;
  const double whole = std::max(1.0, std::round(periods));
  if (std::abs(periods - whole) > kFit)
    ++irregular;
  else
    missing += static_cast<std::int64_t>(whole) - 1;
}

std::int64_t FrameClock::dropped() const {
  if (early_intervals_s_.empty()) return 0;
  Tally all = later_;
  const double typical_s = typical_interval_s();
  for (const double interval_s : early_intervals_s_) all.add(interval_s, typical_s);
  return 10 * all.irregular > all.intervals ? 0 : all.missing;
}

std::optional<double> FrameClock::observed_rate_hz() const {
  if (early_intervals_s_.size() < kIntervalsForRate) return std::nullopt;
  return 1.0 / typical_interval_s();
}

}  // namespace vildar
