#pragma once

#include <optional>
#include <span>
#include <vector>

#include "calib/site/learn.h"

namespace vildar {

/// Two runs, by index, whose own passes put a turn of the camera apart.
struct TurnedCamera {
  std::size_t one = 0, other = 0;
  LearnedQuantity by_one, by_other;
};

/// The first two runs between which the camera was turned by more than 0.1 degrees and four sigmas.
/// How far vehicles drive from along the road is learned from all runs together, each about its own
/// mean, so that runs of two passes can be judged; one pass alone is not.
std::optional<TurnedCamera> turned_camera(std::span<const std::vector<VehicleTrack>> runs,
                                          const Site& site);

}  // namespace vildar
