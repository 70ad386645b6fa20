#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/outcome.h"
#include "types/site.h"
#include "types/vehicle_track.h"

namespace vildar {

/// A quantity of the site file that passes share: before, after, and what lies behind it. SI units,
/// a focal length in pixels.
struct LearnedQuantity {
  std::string key;          ///< in the site file, e.g. `camera.yaw_deg`
  bool angle = false;       ///< radians; else metres or pixels
  Uncertain before, after;  ///< as the site file states them
  double mean_std = 0.0;    ///< of the mean over all vehicles
  double spread = 0.0;      ///< of single vehicles about that mean
  /// How far the passes put the site's mean from where the site file does, over the sigma of such
  /// ways: the root of prior less posterior variance, at least of a tenth of the prior's. 0 where
  /// it stays.
  double strain = 0.0;
  int passes = 0;  ///< that tell of it
};

struct SiteLearning {
  Site site;  ///< improved
  std::vector<LearnedQuantity> quantities;
  std::vector<std::size_t> took_part;   ///< passes, by index
  std::map<std::string, int> left_out;  ///< passes left out, by reason
  /// Median relative sigma of the speeds of the passes, with the site as given and as learned.
  double speed_std_before = 0.0, speed_std_after = 0.0;
  /// Relative sigma that all lengths, and so all speeds, have in common; and what it was before.
  double common_scale_std = 0.0, common_scale_std_before = 0.0;
  double last_turn_rad = 0.0;  ///< of the pose, in the last of at most four rounds

  int passes() const { return static_cast<int>(took_part.size()); }
  bool settled() const { return last_turn_rad < 1e-5; }
  /// Whether what was learned lies farther from what the file states than one correct file in a
  /// hundred would make it, one quantity or all together. Something there is then off, which may be
  /// one that is not learned, and all that was learned bent with it.
  bool strains_the_file() const;
  /// The quantity that lies farthest from what the file states, where that is 4.5 sigmas and more:
  /// of ten quantities one right file in ten thousand has one. What is not learned, as a lens that
  /// the file does not describe, bends what is by as much.
  std::optional<LearnedQuantity> denied() const;
};

/// Learns from passes what they share: the turns and the focal length of the camera that the site
/// file does not call known, the mean and the spread of the lamps' height and separation, and of
/// the line driven in each lane. One joint least-squares problem over all passes: each pass has its
/// own trajectory and its own value of each shared quantity, drawn from a normal population of
/// unknown mean and spread. A stated `{mean, std}` is taken as half variance among sites, half
/// among the vehicles of one.
///
/// Bearings leave the common scale of all lengths open: it rests on the site file alone, stays in
/// the stated sigmas, and is told. What fewer than `fewest` passes tell of stays as it was. Passes
/// unlike the others are left out.
///
/// Requires a fixed camera (std::invalid_argument otherwise).
/// Misses: too_few_samples (fewer than `fewest` usable passes), not_converged, unobservable.
Outcome<SiteLearning> learn_site(std::span<const VehicleTrack> passes, const Site& site,
                                 int fewest = 5);

}  // namespace vildar
