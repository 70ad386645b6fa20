#pragma once

#include <vector>

#include "optics/camera.h"
#include "synth/ego.h"
#include "synth/scenario.h"

namespace vildar {

/// Where the rays of an image meet the road plane, worked out once: every `step_px` pixels in both
/// directions.
class GroundMap {
 public:
  GroundMap(const Camera& camera, const CameraSite& site, int step_px);

  struct Point {
    float x_m = 0.0F, y_m = 0.0F;  ///< frame that moves with the sensors
    float width_m = 0.0F;          ///< across the line of sight, of one pixel
    bool ground = false;
    float elevation_rad = 0.0F;  ///< of the ray
  };
  int step_px() const { return step_px_; }
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  const Point& at(int column, int row) const {
    return points_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                   static_cast<std::size_t>(column)];
  }

 private:
  int step_px_, columns_, rows_;
  std::vector<Point> points_;
};

/// What the camera sees without any lamp. Luminance, and the share of light that the surface sends
/// back relative to asphalt (0 for the sky), per pixel, row by row.
struct Background {
  std::vector<float> cd_per_m2;
  std::vector<float> surface;
};
/// Sky with its glow, verge, asphalt with painted edge lines. `map` has a step of one pixel.
Background background_of(const GroundMap& map, const Scenario& scenario, const EgoPose& ego);

}  // namespace vildar
