#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/random.h"
#include "optics/response.h"
#include "types/frame.h"

namespace vildar::scene {

/// A picture in linear light, drawn in closed form, then turned into codes.
class Picture {
 public:
  Picture(int width_px, int height_px, double background = 0.0)
      : width_px_(width_px),
        height_px_(height_px),
        light_(static_cast<std::size_t>(width_px) * height_px, background) {}

  /// Gaussian spot of total light `flux`, integrated over each pixel.
  void add_gaussian(double u, double v, double spread_px, double flux) {
    const auto part = [&](int pixel, double centre) {
      const double scale = 1.0 / (spread_px * std::sqrt(2.0));
      return 0.5 *
             (std::erf((pixel + 0.5 - centre) * scale) - std::erf((pixel - 0.5 - centre) * scale));
    };
    std::vector<double> part_u, part_v;
    for (int x = 0; x < width_px_; ++x) part_u.push_back(part(x, u));
    for (int y = 0; y < height_px_; ++y) part_v.push_back(part(y, v));
    for (int y = 0; y < height_px_; ++y)
      for (int x = 0; x < width_px_; ++x) at(x, y) += flux * part_u[x] * part_v[y];
  }

  /// Disc of uniform light, its rim anti-aliased by 8 x 8 samples.
  void add_disc(double u, double v, double radius_px, double level) {
    for (int y = 0; y < height_px_; ++y)
      for (int x = 0; x < width_px_; ++x) {
        if (std::hypot(x - u, y - v) > radius_px + 1.0) continue;
        int inside = 0;
        for (int i = 0; i < 64; ++i)
          inside +=
              std::hypot(x + (i % 8 - 3.5) / 8.0 - u, y + (i / 8 - 3.5) / 8.0 - v) <= radius_px;
        at(x, y) += level * inside / 64.0;
      }
  }

  double& at(int x, int y) { return light_[static_cast<std::size_t>(y) * width_px_ + x]; }

  /// Codes = black + response^-1(light) * (white - black) + noise, rounded and clipped to
  /// 0..clip_code.
  Frame frame(const Response& response, int bit_depth, int black_code, int white_code,
              int clip_code, double noise_codes = 0.0, std::uint64_t seed = 1) const {
    const int bytes = bit_depth > 8 ? 2 : 1;
    auto plane = std::make_shared<std::vector<std::uint8_t>>(light_.size() * bytes);
    Random random(seed);
    for (std::size_t i = 0; i < light_.size(); ++i) {
      const double exact =
          black_code + response.fraction_from_linear(light_[i]) * (white_code - black_code);
      const double noisy = exact + (noise_codes > 0.0 ? random.normal(0.0, noise_codes) : 0.0);
      const int code = static_cast<int>(std::lround(std::clamp<double>(noisy, 0.0, clip_code)));
      (*plane)[i * bytes] = static_cast<std::uint8_t>(code);
      if (bytes == 2) (*plane)[i * 2 + 1] = static_cast<std::uint8_t>(code >> 8);
    }
    Frame frame;
    frame.luma.data = plane->data();
    frame.luma.owner = std::move(plane);
    frame.luma.stride_bytes = width_px_ * bytes;
    frame.luma.width_px = width_px_;
    frame.luma.height_px = height_px_;
    frame.luma.bit_depth = bit_depth;
    frame.luma.black_code = black_code;
    frame.luma.white_code = white_code;
    return frame;
  }
  /// 8 bit, full range.
  Frame frame8(double noise_codes = 0.0, std::uint64_t seed = 1) const {
    return frame(Response(), 8, 0, 255, 255, noise_codes, seed);
  }

 private:
  int width_px_, height_px_;
  std::vector<double> light_;
};

}  // namespace vildar::scene
