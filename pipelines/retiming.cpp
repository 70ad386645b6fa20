#include "pipelines/retiming.h"

#include <chrono>
#include <cmath>

#include "core/camera_rate.h"

namespace vildar {

void EvenStamps::add(std::int64_t frame, CameraTime time) {
  constexpr double kMostUneven = 0.1;  // of a step: stamps of whole milliseconds
  const double time_s = seconds_of(time);
  if (frames_ == 0) {
    first_ = frame;
    first_s_ = time_s;
  } else {
    const double step_s = (time_s - last_s_) / static_cast<double>(frame - last_);
    if (frames_ == 1) step_s_ = step_s;
    even_ &= step_s > 0.0 && std::abs(step_s - step_s_) < kMostUneven * step_s_;
  }
  last_ = frame;
  last_s_ = time_s;
  ++frames_;
}

double EvenStamps::frame_s() const {
  return (last_s_ - first_s_) / static_cast<double>(last_ - first_);
}

CameraTime Retiming::time_of(std::int64_t frame) const {
  const double time_s = first_s + change.taken_at(frame) * frame_s;
  return CameraTime(std::chrono::nanoseconds(std::llround(time_s * 1e9)));
}

std::optional<Retiming> retiming_of(const EvenStamps& stamps, std::span<const std::int64_t> repeats,
                                    std::span<const std::int64_t> after_gaps) {
  if (!stamps.even()) return std::nullopt;
  auto change = RateChange::by_repeats(repeats);
  if (change) return Retiming{*change, stamps.first_s(), stamps.frame_s()};
  // Frames of a recorder under load may be missing as regularly, and the stamps go on as if none
  // were.
  constexpr double kOff = 0.004;
  change = RateChange::by_gaps(after_gaps);
  if (!change || !is_camera_rate(change->rate_factor() / stamps.frame_s(), kOff))
    return std::nullopt;
  return Retiming{*change, stamps.first_s(), stamps.frame_s()};
}

}  // namespace vildar
