#pragma once

#include <optional>
#include <vector>

#include "track/lone_parts.h"
#include "track/road_view.h"

namespace vildar {

/// A frame in which both lamps of a vehicle were seen as a pair; places as in RoadView.
struct PairPlace {
  double time_s;
  Eigen::Vector2d left_px, right_px;
};

/// Where the lamps of a vehicle were when they were not seen, from the pairs next to that time: at
/// constant speed along the road.
class LampWay {
 public:
  /// In order of time.
  LampWay(std::vector<PairPlace> pairs, const RoadView& view);

  struct Place {
    Eigen::Vector2d left_px, right_px;
    Eigen::Vector2d along;       ///< unit vector of the way
    double along_px, across_px;  ///< how far off the lamps may be, along the way and across it
  };
  /// Nothing where too few pairs tell a way, or it has passed the camera; nor from a sensor that
  /// moves, whose own turning moves the lamps as well.
  std::optional<Place> at(double time_s) const;

 private:
  std::vector<PairPlace> pairs_;
  std::vector<double> depth_m_;  ///< of each
  const RoadView& view_;
};

/// Leaves out the frames of a vehicle in which one light alone was seen, where that stood beside
/// the way that its pairs say its lamp went: it was another lamp, or an image on the road. In order
/// of frames.
void drop_beside_the_way(std::vector<SeenVehicle>& seen, const RoadView& view);

}  // namespace vildar
