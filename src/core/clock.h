#pragma once

#include <chrono>
#include <cmath>

namespace vildar {

/// Each device has a clock of its own; subtracting a photodiode time from a camera time does not
/// compile. Only a calibrated or estimated offset crosses over.
template <class Device>
struct DeviceClock {
  using duration = std::chrono::nanoseconds;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<DeviceClock>;
  static constexpr bool is_steady = true;
};

/// Of a recorded clip the epoch is the presentation time of its first frame.
using CameraTime = DeviceClock<struct CameraDevice>::time_point;
using DiodeTime = DeviceClock<struct DiodeDevice>::time_point;

/// Seconds since the epoch of the clock.
template <class Clock>
constexpr double seconds_of(std::chrono::time_point<Clock, std::chrono::nanoseconds> time) {
  return static_cast<double>(time.time_since_epoch().count()) * 1e-9;
}

/// Nearest nanosecond; `time_s` is finite and within +-9e9.
template <class Time>
Time time_from_seconds(double time_s) {
  return Time(std::chrono::nanoseconds(std::llround(time_s * 1e9)));
}

/// Instant at which a lamp seen in a rolling-shutter frame holds. `row_fraction` is
/// (row + 0.5) / rows - 0.5 in readout order, so 0 is the middle row, whose mid-exposure is
/// `frame_time`.
inline CameraTime row_time(CameraTime frame_time, double rolling_shutter_s, double row_fraction) {
  return frame_time +
         std::chrono::nanoseconds(std::llround(rolling_shutter_s * row_fraction * 1e9));
}

}  // namespace vildar
