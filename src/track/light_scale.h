#pragma once

#include <optional>
#include <vector>

#include "types/blob.h"

namespace vildar {

/// What the lamps of this scene are like: whether they show colour, and how strong they are,
/// ln(flux x depth^2), which for one exposure is the same near and far. Glints on car bodies, paint
/// and lit road are far below it.
class LightScale {
 public:
  /// `strength` of a vehicle that is beyond doubt, the slope under which it was seen (fall per
  /// metre of depth), and whether its lamps clip.
  void add(LampKind kind, double strength, double slope_down, bool clips);
  /// Upper quartile of the latest ones, for headlamps at least that of tail lamps; nothing before
  /// there are enough.
  std::optional<double> typical(LampKind kind) const;
  /// Whether enough of this very kind are known to say how strong they may be at most.
  bool knows(LampKind kind) const;
  /// Lamps of this kind are seldom weaker: the typical strength, or that of the one or two that are
  /// known less what those may be stronger than usual ones.
  std::optional<double> at_least(LampKind kind) const;
  /// By how much strengths of headlamps seen under this slope may be less than those: low beams
  /// send less of their light the more steeply up one looks from. Not negative; zero for other
  /// kinds.
  double dimmer_ln(double slope_down, LampKind kind) const;
  /// Whether most lamps clip; false before there are enough.
  bool usually_clips(LampKind kind) const;

  void see_colour(double cr, double cb);
  /// The lights seen so far are grey but for noise, and next to none is red: a grey camera, or one
  /// by infrared light. False before any is seen.
  bool colourless() const;

 private:
  struct Memory {
    std::vector<double> strengths, slopes_down;
    std::vector<char> clips;
    std::size_t next = 0;
  };
  const Memory& of(LampKind kind) const { return kind == LampKind::taillamp ? tail_ : head_; }

  Memory head_, tail_;
  double colour_sum_ = 0.0;  ///< of distances from grey
  int red_ = 0, lights_ = 0;
};

}  // namespace vildar
