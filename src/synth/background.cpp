#include "synth/background.h"

#include <algorithm>
#include <cmath>

#include "optics/road.h"

namespace vildar {
namespace {

constexpr double kVergeShare = 0.35;  // grass and gravel against asphalt
constexpr double kPaintShare = 2.5;
constexpr double kPaintWidth_m = 0.12;

// Luminance of a ground point, edges softened over the width that a pixel covers there.
double ground_cd_per_m2(const RoadSite& road, const ImageScene& image, double x_m, double y_m,
                        double pixel_width_m) {
  const double lateral_m = road_position(road, x_m, y_m).lateral_m;
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
  return image.road_cd_per_m2 * (share + (kPaintShare - share) * paint);
}

}  // namespace

std::vector<float> background_cd_per_m2(const Camera& camera, const CameraSite& site,
                                        const RoadSite& road, const ImageScene& image) {
  std::vector<float> light(static_cast<std::size_t>(site.width_px) *
                           static_cast<std::size_t>(site.height_px));
  std::size_t place = 0;
  for (int v = 0; v < site.height_px; ++v)
    for (int u = 0; u < site.width_px; ++u, ++place) {
      double luminance = image.sky_cd_per_m2;
      const auto ground_m = camera.plane_point_m({u, v}, 0.0);
      if (ground_m) {
        const double away_m = (*ground_m - camera.position_m().head<2>()).norm();
        luminance =
            ground_cd_per_m2(road, image, ground_m->x(), ground_m->y(),
                             std::hypot(away_m, camera.position_m().z()) / camera.focal_px());
      }
      light[place] = static_cast<float>(luminance);
    }
  return light;
}

}  // namespace vildar
