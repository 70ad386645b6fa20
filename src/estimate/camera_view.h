#pragma once

#include <vector>

#include "optics/camera.h"
#include "types/result.h"
#include "types/site.h"
#include "types/vehicle_track.h"

namespace vildar {

/// One lamp in one frame as the trajectory fit wants it.
struct LampObservation {
  std::size_t sighting = 0;  ///< index into the track's sightings
  double time_s = 0.0;       ///< clip time at which the lamp's row holds
  Eigen::Vector2d normalized = Eigen::Vector2d::Zero();  ///< undistorted x/z, y/z in camera axes
  Eigen::Vector2d sigma = Eigen::Vector2d::Ones();       ///< of the same
  /// Place on the vehicle, in separations: +1/2 the lamp left in the image, -1/2 right, 0 the
  /// middle.
  double side = 0.0;
};

/// What of a vehicle its bearings are taken of.
enum class BearingOf { pair, each_lamp, middle, left_lamp, right_lamp };

/// Observations of a track in time order of its sightings. `pair`: of both lamps, without the
/// frames that show one alone, if those that show two suffice: far away, one spot can be either
/// lamp or both. `each_lamp`: of whatever is seen, where a few frames show two. Else of that one
/// place on the vehicle which most frames show. The middle of its lamps is seen where both are, and
/// where one blob holds both.
struct CameraView {
  std::vector<LampObservation> lamps;
  int frames = 0;  ///< sightings that gave an observation
  BearingOf of = BearingOf::middle;

  /// Whether the distance of the lamps takes part.
  bool pairs() const { return of == BearingOf::pair || of == BearingOf::each_lamp; }
};
/// One sighting's share of this; empty where it does not show that place.
std::vector<LampObservation> frame_lamps(const VehicleSighting& sighting, std::size_t index,
                                         BearingOf of, const Camera& camera,
                                         const CameraSite& site);
CameraView camera_view(const VehicleTrack& track, const Camera& camera, const CameraSite& site);

/// Light and bearings of each sighting, from the pixels alone.
std::vector<TrackRow> bearing_rows(const VehicleTrack& track, const Camera& camera,
                                   const Site& site);

}  // namespace vildar
