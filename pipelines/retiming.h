#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "capture/rate_change.h"
#include "core/clock.h"

namespace vildar {

/// Gathers the time stamps of a clip as it is read.
class EvenStamps {
 public:
  void add(std::int64_t frame, CameraTime time);
  /// Whether each frame came as long after the one before as the second after the first.
  bool even() const { return frames_ > 1 && even_; }
  double first_s() const { return first_s_; }
  /// From one to the next.
  double frame_s() const;

 private:
  std::int64_t first_ = 0, last_ = 0, frames_ = 0;
  double first_s_ = 0.0, last_s_ = 0.0, step_s_ = 0.0;
  bool even_ = true;
};

/// Times of the frames of a clip that was given another rate: even ones of the rate that it had.
struct Retiming {
  RateChange change;
  double first_s = 0.0, frame_s = 0.0;  ///< as stamped

  CameraTime time_of(std::int64_t frame) const;
  double rate_hz() const { return change.rate_factor() / frame_s; }
};

/// Nothing where the stamps are uneven, or neither the frames that repeat the one before nor those
/// before which one is missing come regularly.
std::optional<Retiming> retiming_of(const EvenStamps& stamps, std::span<const std::int64_t> repeats,
                                    std::span<const std::int64_t> after_gaps);

}  // namespace vildar
