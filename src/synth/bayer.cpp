#include "synth/bayer.h"

namespace vildar {

std::array<std::vector<float>, 3> demosaic(const std::vector<float>& mosaic, int width_px,
                                           int height_px) {
  const auto width = static_cast<std::size_t>(width_px);
  std::array<std::vector<float>, 3> planes;
  for (std::vector<float>& plane : planes) plane.resize(mosaic.size());
  for (int v = 0; v < height_px; ++v)
    for (int u = 0; u < width_px; ++u) {
      float sum[3] = {0.0F, 0.0F, 0.0F};
      int count[3] = {0, 0, 0};
      const int own = bayer_colour(u, v);
      for (int dv = -1; dv <= 1; ++dv)
        for (int du = -1; du <= 1; ++du) {
          const int column = u + du, row = v + dv;
          if (column < 0 || row < 0 || column >= width_px || row >= height_px) continue;
          const int colour = bayer_colour(column, row);
          // What a pixel sees itself is taken from it alone.
          if (colour == own && (du != 0 || dv != 0)) continue;
          sum[colour] +=
              mosaic[static_cast<std::size_t>(row) * width + static_cast<std::size_t>(column)];
          ++count[colour];
        }
      const std::size_t place = static_cast<std::size_t>(v) * width + static_cast<std::size_t>(u);
      for (std::size_t colour = 0; colour < 3; ++colour)
        planes[colour][place] = sum[colour] / static_cast<float>(count[colour]);
    }
  return planes;
}

}  // namespace vildar
