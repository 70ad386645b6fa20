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

/// A quantity of the site file: before, after, and what lies behind it.
struct LearnedPhotodiode {
  std::string key;   ///< in the site file, e.g. `photodiodes[1].gain_ratio`
  std::string unit;  ///< "s", or "" for a ratio
  Uncertain before, after;
  int passes = 0;  ///< that tell of it
};

struct PhotodiodeLearning {
  Site site;  ///< improved
  std::vector<LearnedPhotodiode> quantities;
  int passes = 0;                       ///< that took part
  std::map<std::string, int> left_out;  ///< passes left out, by reason
  bool settled = false;                 ///< the last round moved nothing by a tenth of its sigma
  /// Median relative sigma of the speeds from camera and photodiodes, before and after.
  double speed_std_before = 0.0, speed_std_after = 0.0;
};

/// Learns the photodiodes' time offset, and their gains relative to the first, from passes that
/// camera and photodiodes both saw: each pass's joint problem of bearings and power with all its
/// own unknowns eliminated (Schur complement), summed with the site file's priors, in up to four
/// rounds about the means found. Known (std 0) quantities stay. Passes unlike the others are left
/// out, and where those that remain differ by more than their sigmas, what is learned is that much
/// less sure. The error that all lengths of the site have in common, and that of the first
/// photodiode's place along the road, stay in the sigma of the offset.
///
/// Misses: unobservable (nothing has a std, or no photodiode), too_few_samples (fewer than five
/// passes whose power fits).
Outcome<PhotodiodeLearning> learn_photodiodes(std::span<const LitPass> passes, const Site& site);

}  // namespace vildar
