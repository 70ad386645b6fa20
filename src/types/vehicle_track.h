#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "types/blob.h"

namespace vildar {

enum class Direction : std::uint8_t { oncoming, receding };

/// One lamp of a vehicle in one frame.
struct LampSighting {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d centre_sigma_px = Eigen::Vector2d::Constant(1.0);
  double flux = 0.0;
  double flux_sigma = 0.0;
  int saturated_px = 0;
  PixelBox box;
  double row_fraction = 0.0;
  Defect defects = Defect::none;
  std::optional<LampLight> lamp;  ///< see Blob
};

/// A vehicle in one frame; left and right as seen in the image. At least one lamp is present; a
/// vehicle that shows one lamp alone has it as `left` unless the track knows which one is missing.
struct VehicleSighting {
  std::int64_t frame = 0;
  CameraTime time;
  std::optional<LampSighting> left;
  std::optional<LampSighting> right;
  /// The lamp present is a blob that holds both, off their middle by no more than its sigma says.
  bool both_in_one = false;
};

/// A vehicle followed through the clip, in frame order, gaps allowed.
struct VehicleTrack {
  int id = 0;  ///< 1, 2, 3, ... in the order in which they are reported
  Direction direction = Direction::oncoming;
  LampKind kind = LampKind::headlamp;  ///< headlamp or taillamp
  bool single_lamp = false;            ///< a motorcycle or a broken lamp: never seen as a pair
  /// The track crossed or merged with another so that its later part may belong to the other.
  bool ambiguous_identity = false;
  /// It was cut where its lamps came apart, and they are followed on as others.
  bool lamps_go_on = false;
  /// Colour says one direction of travel, motion the other.
  bool direction_contradicts = false;
  /// From high above, in most frames a light stands between its lamps, level with them.
  bool lights_between = false;
  /// Drives here across the road, beside the lanes of the site file: no speed is told of it.
  std::optional<double> beside_lanes_m;
  std::vector<VehicleSighting> sightings;
};

}  // namespace vildar
