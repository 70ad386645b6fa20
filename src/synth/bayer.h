#pragma once

#include <array>
#include <vector>

namespace vildar {

/// Which colour (0 red, 1 green, 2 blue) a pixel of an RGGB mosaic sees.
constexpr int bayer_colour(int u, int v) { return (u & 1) + (v & 1); }

/// Full-colour image from a mosaic, bilinear: a missing colour is the mean of the nearest pixels
/// that see it. `mosaic` and the results are row by row; width and height at least 2.
std::array<std::vector<float>, 3> demosaic(const std::vector<float>& mosaic, int width_px,
                                           int height_px);

}  // namespace vildar
