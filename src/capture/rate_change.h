#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace vildar {

/// How a clip was given another frame rate: at regular intervals a frame is shown once more (25
/// frames/s made 30), or one is left out (30 made 25). Its time stamps are even, but its frames
/// were taken at even times of another rate, and stand up to half a frame early and late by turns.
class RateChange {
 public:
  /// Told by the numbers of frames that show the one before again, in rising order, if not all;
  /// nothing where so regular a series may come about by chance.
  static std::optional<RateChange> by_repeats(std::span<const std::int64_t> frames);
  /// The same by the numbers of frames before which one was left out.
  static std::optional<RateChange> by_gaps(std::span<const std::int64_t> frames);

  /// When a frame was taken, in frames of the clip from its first: of all of them together the
  /// stamps are right. Frames that show one picture were taken at one time.
  double taken_at(std::int64_t frame) const;
  /// Frames that were taken for each that the clip has.
  double rate_factor() const { return 1.0 + more_ / period_; }
  bool repeats() const { return more_ < 0.0; }

 private:
  RateChange(double period, double first, double more)
      : period_(period), first_(first), more_(more) {}
  static std::optional<RateChange> by_events(std::span<const std::int64_t> frames, double more);

  double period_;  ///< frames from one event to the next
  double first_;   ///< an event is at the first frame not before this, and whole periods on
  double more_;    ///< pictures that the clock gains there: -1 or 1
};

}  // namespace vildar
