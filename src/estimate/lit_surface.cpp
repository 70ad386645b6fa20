#include "estimate/lit_surface.h"

#include <algorithm>
#include <vector>

#include "core/median.h"

namespace vildar {

std::optional<double> width_of_surface_m(std::span<const TrackRow> rows, const CameraSite& camera) {
  constexpr double kWidest_m = 0.45;
  constexpr int kLeast_px = 12;  // more than blur makes of a lamp
  constexpr std::size_t kFewest = 5;
  std::vector<double> width_m;
  std::size_t ranged = 0;
  for (const TrackRow& row : rows) {
    if (!row.range_m) continue;
    ++ranged;
    for (const auto& lamp : {row.sighting.left, row.sighting.right}) {
      if (!lamp) continue;
      const PixelBox& box = lamp->box;
      const int width_px = std::min(box.u_max - box.u_min, box.v_max - box.v_min) + 1;
      if (lamp->saturated_px > 0 || width_px < kLeast_px) continue;
      width_m.push_back(width_px * (*row.range_m - camera.position_m[0].mean) / camera.focal_px[0]);
      break;
    }
  }
  if (width_m.size() < kFewest || 2 * width_m.size() < ranged) return std::nullopt;
  const double middle_m = median(width_m);
  if (middle_m < kWidest_m) return std::nullopt;
  return middle_m;
}

}  // namespace vildar
