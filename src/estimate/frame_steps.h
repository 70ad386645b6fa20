#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "types/result.h"
#include "types/vehicle_track.h"

namespace vildar {

/// Whether the time stamps of a clip tell all the time that passed. A recorder that drops frames
/// and stamps the others as if none were missing makes all vehicles seem faster; their lamps then
/// jump by whole frames' ways where frames are missing. Only steps in which some lamp moves far
/// enough for its noise are judged.
class FrameSteps {
 public:
  /// Of fewer nothing is concluded.
  static constexpr std::int64_t kFewestMissing = 3;

  /// Steps from one frame to the next, of those that were judged.
  struct Tally {
    std::int64_t judged = 0;
    std::int64_t missing = 0;   ///< frames, in steps of two frames' way and more
    std::int64_t jumps = 0;     ///< such steps
    std::int64_t repeated = 0;  ///< steps that show the frame before again
    std::int64_t odd = 0;       ///< steps that are no whole number of frames' ways

    /// Steps judged and jumps by frame number modulo a period: at [period][remainder].
    using ByRemainder = std::array<std::array<std::int64_t, 17>, 17>;
    ByRemainder judged_at{}, jumps_at{};
    double frame_s = 0.0;  ///< from one frame to the next, as stamped

    /// Frames that are missing for which no frame was shown twice; 0 where jumps do not stand out
    /// of what is odd, or come as regularly as where a clip of a camera's rate was given another:
    /// then its stamps are right on the whole.
    std::int64_t unfilled() const;

   private:
    bool regular() const;
  };

  /// What was seen of a vehicle; of one whose camera shakes, as a camera at rest sees it.
  void add(const VehicleTrack& track);
  /// Of the frames `first` to `last`; the last 20 000 steps are kept one by one.
  Tally between(std::int64_t first, std::int64_t last) const;
  Tally all() const;
  /// Frames before which just one seems to be missing, of the last 20 000 steps.
  std::vector<std::int64_t> after_one_missing() const;
  /// Time that the stamps leave out within these frames over what they tell: of the steps judged
  /// there, or of all of the clip where those are few. 0 where fewer than kFewestMissing are
  /// missing in all.
  double missing_share(std::int64_t first, std::int64_t last) const;

 private:
  /// Of one step: sums over lamps of (way x surplus way) and way squared, over the variance.
  struct Evidence {
    double along = 0.0, weight = 0.0;
    bool is_judged() const;
    /// Whole frames' ways by which the step is too long; nothing where it is by no whole number.
    std::optional<double> whole_surplus() const;
    void count_in(Tally& tally, std::int64_t frame) const;
  };
  std::map<std::int64_t, Evidence> steps_;  ///< by the frame that they start from
  Tally forgotten_;
  double frame_s_ = 0.0;
  std::int64_t first_kept_ = 0;
};

/// Whether time left out by such a share changes a speed by half its sigma or more: all that the
/// camera sees of a vehicle's way is its closing speed.
bool bears_on(double missing_share, const VehicleResult& result);

}  // namespace vildar
