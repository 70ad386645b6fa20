#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "core/random.h"
#include "detect/lamp_fit.h"

namespace vildar {

/// A camera of 12 bits with a straight response: 10 000 electrons give nominal white, where pixels
/// clip; 3 electrons of read noise on a background of 20.
class LinearCamera {
 public:
  static constexpr double kFullWell_e = 10000.0, kRead_e = 3.0, kBackground_e = 20.0;
  static constexpr int kBlackCode = 64, kWhiteCode = 4064;

  LinearCamera() {
    for (int code = 0; code < 4096; ++code)
      linear_.push_back(static_cast<float>(code - kBlackCode) / (kWhiteCode - kBlackCode));
  }

  /// Exposes `light`, row by row in units of nominal white, background not included.
  FrameLight expose(const std::vector<double>& light, int width_px, Random& random) const {
    auto plane = std::make_shared<std::vector<std::uint16_t>>(light.size());
    for (std::size_t i = 0; i < light.size(); ++i) {
      const double mean_e = light[i] * kFullWell_e + kBackground_e;
      const double e = random.normal(mean_e, std::sqrt(mean_e + kRead_e * kRead_e));
      const double code = kBlackCode + e / kFullWell_e * (kWhiteCode - kBlackCode);
      (*plane)[i] = static_cast<std::uint16_t>(
          std::lround(std::clamp(code, 0.0, static_cast<double>(kWhiteCode))));
    }
    FrameLight frame;
    frame.luma.data = reinterpret_cast<const std::uint8_t*>(plane->data());
    frame.luma.width_px = width_px;
    frame.luma.height_px = static_cast<int>(light.size()) / width_px;
    frame.luma.stride_bytes = 2 * width_px;
    frame.luma.bit_depth = 12;
    frame.luma.black_code = kBlackCode;
    frame.luma.white_code = kWhiteCode;
    frame.luma.owner = std::move(plane);
    frame.linear = linear_;
    frame.clip_code = kWhiteCode;
    frame.clip_light = 1.0 - 0.5 / (kWhiteCode - kBlackCode);
    frame.noise.dark_variance = kRead_e * kRead_e / (kFullWell_e * kFullWell_e);
    frame.noise.electrons = kFullWell_e;
    frame.noise.rounding = {&kRounding, 1};
    return frame;
  }

  /// Variance of a pixel that such light falls on, background not included.
  static double variance(double light) {
    const double e = light * kFullWell_e + kBackground_e;
    return (e + kRead_e * kRead_e) / (kFullWell_e * kFullWell_e) + static_cast<double>(kRounding);
  }

 private:
  static constexpr float kRounding = 1.0F / 12.0F / 4000.0F / 4000.0F;
  std::vector<float> linear_;
};

/// Radius of the clipped area, and its middle; none where nothing clips.
inline LampGuess guess_of(const FrameLight& frame, double size_px) {
  LampGuess guess;
  guess.size_px = size_px;
  double clipped = 0.0, sum = 0.0;
  Eigen::Vector2d clipped_at = Eigen::Vector2d::Zero(), at = Eigen::Vector2d::Zero();
  for (int v = 0; v < frame.luma.height_px; ++v)
    for (int u = 0; u < frame.luma.width_px; ++u) {
      const int code = frame.luma.code(u, v);
      const double light = std::max(0.0, static_cast<double>(frame.linear[code]) - 0.02);
      sum += light;
      at += light * Eigen::Vector2d(u, v);
      if (code < frame.clip_code) continue;
      clipped += 1.0;
      clipped_at += Eigen::Vector2d(u, v);
    }
  guess.centre_px =
      clipped > 0.0 ? Eigen::Vector2d(clipped_at / clipped) : Eigen::Vector2d(at / sum);
  guess.rim_px = std::sqrt(clipped / 3.14159265358979);
  return guess;
}

}  // namespace vildar
