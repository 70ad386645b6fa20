#include "synth/background.h"

#include <algorithm>
#include <cmath>

#include "optics/road.h"

namespace vildar {
namespace {

constexpr double kVergeShare = 0.35;  // grass and gravel against asphalt
constexpr double kPaintShare = 2.5;
constexpr double kPaintWidth_m = 0.12;

// Light that a ground point sends back against asphalt, edges softened over the width that a pixel
// covers there.
double surface_share(const RoadSite& road, const Eigen::Vector2d& point_m, double pixel_width_m) {
  const double lateral_m = road_position(road, point_m.x(), point_m.y()).lateral_m;
  double paint = 0.0, asphalt = 0.0;
  for (const LaneSite& lane : road.lanes) {
    const double offset_m = std::abs(lateral_m - lane.lateral_m.mean);
    const double inside_m = 0.5 * lane.width_m - offset_m;
    asphalt = std::max(asphalt, std::clamp(inside_m / pixel_width_m + 0.5, 0.0, 1.0));
    const double from_line_m = 0.5 * kPaintWidth_m - std::abs(inside_m);
    const double full = std::min(1.0, kPaintWidth_m / pixel_width_m);
    paint = std::max(paint, full * std::clamp(from_line_m / pixel_width_m + 0.5, 0.0, 1.0));
  }
  const double share = kVergeShare + (1.0 - kVergeShare) * asphalt;
  return share + (kPaintShare - share) * paint;
}

}  // namespace

GroundMap::GroundMap(const Camera& camera, const CameraSite& site, int step_px)
    : step_px_(step_px),
      columns_((site.width_px - 1) / step_px + (step_px > 1 ? 2 : 1)),
      rows_((site.height_px - 1) / step_px + (step_px > 1 ? 2 : 1)) {
  points_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  std::size_t place = 0;
  for (int row = 0; row < rows_; ++row)
    for (int column = 0; column < columns_; ++column, ++place) {
      const Eigen::Vector2d pixel_px(column * step_px, row * step_px);
      Point& point = points_[place];
      const auto ray = camera.road_ray_from_pixel(pixel_px);
      if (!ray) continue;
      point.elevation_rad = static_cast<float>(bearing_of(*ray).elevation_rad);
      const double distance_m = -camera.position_m().z() / ray->z();
      if (!(distance_m > 0.0) || !std::isfinite(distance_m)) continue;
      const Eigen::Vector3d ground_m = camera.position_m() + distance_m * *ray;
      point.x_m = static_cast<float>(ground_m.x());
      point.y_m = static_cast<float>(ground_m.y());
      point.width_m = static_cast<float>(distance_m / camera.focal_px());
      point.ground = true;
    }
}

Background background_of(const GroundMap& map, const Scenario& scenario, const EgoPose& ego) {
  const ImageScene& image = scenario.image;
  const auto count = static_cast<std::size_t>(map.columns()) * static_cast<std::size_t>(map.rows());
  Background background{std::vector<float>(count), std::vector<float>(count)};
  std::size_t place = 0;
  for (int row = 0; row < map.rows(); ++row)
    for (int column = 0; column < map.columns(); ++column, ++place) {
      const GroundMap::Point& point = map.at(column, row);
      if (point.ground) {
        const double share =
            surface_share(scenario.site.road, ego.still_m({point.x_m, point.y_m}), point.width_m);
        background.surface[place] = static_cast<float>(share);
        background.cd_per_m2[place] = static_cast<float>(share * image.road_cd_per_m2);
      } else {
        const double above_rad = std::max(0.0, static_cast<double>(point.elevation_rad));
        const double glow = image.glow_cd_per_m2 * std::exp(-above_rad / image.glow_height_rad);
        background.cd_per_m2[place] = static_cast<float>(image.sky_cd_per_m2 + glow);
      }
    }
  return background;
}

}  // namespace vildar
