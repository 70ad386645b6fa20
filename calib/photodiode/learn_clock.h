#pragma once

#include <map>
#include <span>
#include <string>

#include "core/outcome.h"
#include "estimate/trajectory.h"
#include "types/power.h"
#include "types/site.h"

namespace vildar {

/// A pass that the camera followed, and the whole traces of the photodiodes beside it, which
/// outlive the call.
struct TimedPass {
  Trajectory way;
  std::span<const PowerTrace> traces;
};

/// The time offset of the photodiodes' clock: before, after, and what lies behind it.
struct LearnedClock {
  bool learned = false;  ///< else `after` is as before
  Uncertain before, after;
  double mean_std_s = 0.0;
  double spread_s = 0.0;  ///< by which passes differ
  int passes = 0;         ///< that tell of it
};

/// Fewer passes tell nothing of a site.
inline constexpr int kFewestClockPasses = 5;

struct ClockLearning {
  Site site;  ///< improved, or as it was
  LearnedClock clock;
  /// Passes left out, by reason: rim_not_reached (the lamps are not seen to come into a
  /// photodiode's view, or leave it long after the camera lost them), way_unsure (the trajectory
  /// tells when to no better than 30 ms), light_does_not_fall, unlike_the_others.
  std::map<std::string, int> left_out;
};

/// Learns the time offset from the moments at which lamps leave a photodiode's field of view: there
/// the light falls within milliseconds, whatever the beam, and the camera's trajectory, carried on,
/// says when. The rim itself may be off by a degree from what the site file says, of each
/// photodiode, which is an error in place and not in time, and is learned with the offset: what
/// slow and fast vehicles tell of them differs. The offset is looked for within three of its stated
/// sigmas, ten minutes at most. Nothing is learned from fewer than five passes, or where more than
/// a third of those whose light falls are unlike the others, as those of runs whose clocks differ
/// are.
///
/// Misses: unobservable (no photodiode, or its offset has no std), outside_model (photodiodes whose
/// stated offsets differ).
Outcome<ClockLearning> learn_clock(std::span<const TimedPass> passes, const Site& site);

}  // namespace vildar
