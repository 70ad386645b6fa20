#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

namespace vildar {

/// Turns the stamps of a clip into strictly increasing times from 0; the rules are those of
/// ClipSource.
class FrameClock {
 public:
  using Nanoseconds = std::chrono::nanoseconds;
  using Stamp = std::optional<Nanoseconds>;  ///< absent: the frame has none

  /// `period` > 0: nominal time between frames.
  explicit FrameClock(Nanoseconds period);

  /// Whether place() needs the stamp of the next frame to decide about this one.
  bool doubts(Stamp stamp) const;
  /// Time of the next frame in presentation order. `next` is read only where doubts(stamp).
  Nanoseconds place(Stamp stamp, Stamp next);

  std::int64_t repaired() const { return repaired_; }
  std::int64_t first_repaired() const {
    return first_repaired_;
  }  ///< frame index; where repaired() > 0
  /// Frames missing from an otherwise steady rate; 0 where more than a tenth of the intervals fit
  /// no multiple.
  std::int64_t dropped() const;
  /// From the spacing of good stamps; absent before 10 of them.
  std::optional<double> observed_rate_hz() const;

 private:
  Nanoseconds period() const;
  Nanoseconds repair(Nanoseconds at);
  Nanoseconds accept(Nanoseconds at);
  void note_interval(Nanoseconds interval);
  double typical_interval_s() const;

  Nanoseconds period_;
  Nanoseconds far_;
  Nanoseconds origin_{0};
  Nanoseconds last_{0};
  bool anchored_ = false;      ///< a good stamp fixed origin_
  bool last_genuine_ = false;  ///< last_ came from a stamp
  std::int64_t placed_ = 0;
  std::int64_t repaired_ = 0;
  std::int64_t first_repaired_ = 0;

  struct Tally {
    std::int64_t intervals = 0, irregular = 0, missing = 0;
    void add(double interval_s, double typical_s);
  };
  std::vector<double>
      early_intervals_s_;  ///< the first ones, from which the typical spacing is taken
  Tally later_;
};

}  // namespace vildar
