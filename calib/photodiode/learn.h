#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/outcome.h"
#include "estimate/trajectory.h"
#include "estimate/vehicle.h"
#include "types/site.h"

namespace vildar {

/// A pass that the camera followed, and the photodiodes' traces of it.
struct LitPass {
  Trajectory way;
  std::vector<VehiclePower> power;
};

/// A gain ratio of the site file: before, after, and what lies behind it.
struct LearnedGain {
  std::string key;  ///< in the site file, e.g. `photodiodes[1].gain_ratio`
  Uncertain before, after;
  double mean_std = 0.0;  ///< of the mean of the passes
  double spread = 0.0;    ///< by which passes differ
  bool differs = false;   ///< passes do, by more than was stated of the ratio
  int passes = 0;         ///< that tell of it
};

/// Fewer passes tell nothing of a site.
inline constexpr int kFewestGainPasses = 5;

struct GainLearning {
  Site site;  ///< improved
  std::vector<LearnedGain> gains;
  int passes = 0;  ///< that took part; with fewer than kFewestGainPasses nothing is learned
  std::map<std::string, int> left_out;  ///< passes left out, by reason
  /// Median relative sigma of the speeds from camera and photodiodes, before and after.
  double speed_std_before = 0.0, speed_std_after = 0.0;
};

/// Learns the gains of photodiodes relative to the first from passes that camera and photodiodes
/// both saw: each pass's joint fit of bearings and power tells each ratio with its sigma, and the
/// ratios of all passes are one population whose mean and spread are learned. A ratio known exactly
/// (std 0) stays, as does one that fewer than five passes tell of; a pass unlike the others is left
/// out. The new sigma is that of the mean and the spread together, not more than stated where
/// passes differ by less than that.
///
/// Misses: unobservable (no ratio has a std).
Outcome<GainLearning> learn_gains(std::span<const LitPass> passes, const Site& site);

}  // namespace vildar
