#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "detect/frame_light.h"

namespace vildar {

/// Rows of numbers, one of each pixel; all of the same length, a multiple of DiscImage::kBatch.
using PixelRow = std::span<const float>;

/// `sum` = `base`, which is zero where empty, and each row times its factor.
void set_rows(std::span<const PixelRow> rows, std::span<const float> factors, PixelRow base,
              std::span<float> sum);

/// Of each pixel, with x its numbers in all rows, x' R' R x. `root` holds R, upper triangular: its
/// first row, its second from the diagonal on ...
void set_forms(std::span<const PixelRow> rows, std::span<const float> root, std::span<float> forms);

/// Of each row, the sum of its products with `factor`.
void sum_products(std::span<const PixelRow> rows, PixelRow factor, std::span<double> sums);

/// Of each pair of rows, the sum of their products times `weight`; row by row, below the diagonal
/// and on it: (0, 0), (1, 0), (1, 1), (2, 0) ...
void sum_squares(std::span<const PixelRow> rows, PixelRow weight, std::span<double> sums);

/// Rings about a lamp, see ResidualShape.
struct LampRings {
  float u_px, v_px;  ///< its centre
  float inner_px, per_px;
};
/// Of each pixel its place about the lamp in whose rings it lies furthest in, the last of those; of
/// those of which nothing is kept the number after the last place.
void set_places(PixelRow u_px, PixelRow v_px, PixelRow keep, std::span<const LampRings> lamps,
                std::span<std::int32_t> places);

/// What a model makes of pixels that do not clip.
struct WeighedRows {
  PixelRow light, keep;         ///< measured; share of its information that counts
  PixelRow expected, backdrop;  ///< by the model; of it what is not the lamps'
  PixelRow weight_before;       ///< of the parameters accepted last
  std::span<float> residual, weight, pull, noise_share;  ///< out; see LampFitter
};
struct WeighedCosts {
  double own = 0.0;     ///< chi-square
  double frozen = 0.0;  ///< with the weights of before
};
/// Weights are 1 over the variance of the model's light, `patch_variance` of the backdrop's square
/// included.
WeighedCosts weigh(const WeighedRows& rows, const PixelNoise& noise, double patch_variance);

}  // namespace vildar
