#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "types/blob.h"
#include "types/camera_turn.h"
#include "types/site.h"
#include "types/vehicle_track.h"

namespace vildar {

struct TrackOptions {
  /// A lamp unseen for longer is lost; (0, 5]. A standing camera waits 2.4 times as long for both
  /// lamps of a vehicle that it has long seen as a pair.
  double longest_gap_s = 0.7;
  int min_sightings = 5;           ///< of a reported vehicle; >= 2
  double min_duration_s = 0.2;     ///< from its first to its last sighting; >= 0
  double min_single_lamp_s = 0.6;  ///< the same for a vehicle of which one lamp alone was seen
  double gate_chi2 =
      14.0;  ///< squared Mahalanobis distance (2 dof) a blob may have from a lamp; > 0

  /// Every violated rule, each with field, value and range.
  std::vector<std::string> problems() const;
};

/// What became of the lights that are not reported as vehicles; all but `blobs` count tracks.
struct TrackCounts {
  std::int64_t blobs = 0;
  std::int64_t static_lights = 0;  ///< street lamps, signs and the like
  std::int64_t reflections = 0;    ///< on the road, or on the vehicle's own body
  std::int64_t short_tracks = 0;   ///< vehicles seen too briefly, or in too few frames
  std::int64_t off_road = 0;       ///< beside the lanes of the site file, and not plainly driving
  std::int64_t undecided = 0;      ///< single lights that never showed that they are a vehicle
  /// Of single lights that are neither vehicles nor reflections: before a camera that stands moved
  /// for a second or more, by 50 mrad or more.
  std::int64_t moving_lights = 0;
  /// Of those undecided: one clipped area, wider than a lamp, that comes or goes.
  std::int64_t saturated = 0;
};

/// Follows lamps from frame to frame and joins them into vehicles. Not thread-safe; one per clip.
class Tracker {
 public:
  /// Throws std::invalid_argument when the options have problems or the site has no camera.
  Tracker(TrackOptions options, const Site& site);
  ~Tracker();
  Tracker(Tracker&&) noexcept;
  Tracker& operator=(Tracker&&) noexcept;

  /// Takes the blobs of the next frame and sets their kind as far as it is known by now. Returns
  /// the vehicles that ended, i.e. that left the image, or were lost within it so long ago that
  /// they are not waited for any more (3.5 s). Throws
  /// std::invalid_argument when the time is not after that of the frame before.
  std::vector<VehicleTrack> update(BlobFrame& blobs);

  /// Ends all tracks and returns those that are vehicles. More frames of the same clip may follow;
  /// ids and counts go on.
  std::vector<VehicleTrack> finish();

  const TrackCounts& counts() const;

  /// How the camera was turned in each of a vehicle's frames, ascending, from the lights that stand
  /// in the world; to be asked before the next update. Nothing where no light stands, and where the
  /// camera moves less than the lights can tell.
  std::vector<std::optional<CameraTurn>> turns_in(std::span<const std::int64_t> frames) const;

  /// First sighting of the oldest light still followed, or waited for, that may yet be reported as
  /// a vehicle: later tracks begin no earlier. Lights that stand in the world do not count, and of
  /// pairs that have not moved yet only the last minutes. Nothing where there is none.
  std::optional<CameraTime> live_since() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace vildar
