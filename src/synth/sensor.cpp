#include "synth/sensor.h"

#include <algorithm>
#include <cmath>

#include "core/quantity.h"

namespace vildar {
namespace {

constexpr int kNormalBits = 12;
constexpr int kNormals = 1 << kNormalBits;
constexpr int kShares = 65535;
constexpr double kRed = 0.2126, kGreen = 0.7152, kBlue = 0.0722;  // BT.709

// Inverse of the normal distribution function by Newton steps on erfc.
double normal_quantile(double probability) {
  double x = 0.0;
  for (int step = 0; step < 60; ++step) {
    const double error = 0.5 * std::erfc(-x * std::sqrt(0.5)) - probability;
    const double slope = std::exp(-0.5 * x * x) / std::sqrt(2.0 * kPi);
    const double move = std::clamp(error / slope, -0.5, 0.5);
    x -= move;
    if (std::abs(move) < 1e-12) break;
  }
  return x;
}

// The finalizer of SplitMix64: a counter in, 64 well-mixed bits out.
std::uint64_t mixed(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

}  // namespace

Sensor::Sensor(const ImageScene& image, const CameraSite& camera, double exposure_s,
               std::uint64_t seed)
    : full_well_e_(image.full_well_e),
      fixed_variance_e2_(static_cast<float>(image.read_noise_e * image.read_noise_e +
                                            image.dark_e_per_s * exposure_s)),
      black_level_e_(static_cast<float>(image.black_level_e)),
      prnu_(static_cast<float>(image.prnu)),
      shot_(image.shot_noise ? 1.0F : 0.0F),
      noisy_(image.shot_noise || fixed_variance_e2_ > 0.0F),
      key_(mixed(seed + 0x9e3779b97f4a7c15ULL)),
      normal_(kNormals),
      codes_(kShares + 1),
      fractions_(kShares + 1) {
  double sum2 = 0.0;
  for (int i = 0; i < kNormals; ++i) {
    const double quantile = normal_quantile((i + 0.5) / kNormals);
    normal_[static_cast<std::size_t>(i)] = static_cast<float>(quantile);
    sum2 += quantile * quantile;
  }
  const auto unit = static_cast<float>(1.0 / std::sqrt(sum2 / kNormals));
  for (float& value : normal_) value *= unit;

  const Response response(camera);
  for (std::size_t i = 0; i < codes_.size(); ++i) {
    const double share = std::min(
        1.0, response.fraction_from_linear(static_cast<double>(i) / static_cast<double>(kShares)));
    fractions_[i] = static_cast<float>(share);
    codes_[i] =
        static_cast<std::uint8_t>(std::lround(kBlackCode + (kWhiteCode - kBlackCode) * share));
  }
}

void Sensor::expose_row(float* light_e, int count, std::int64_t frame, int row) const {
  constexpr int kBatch = 4;
  if (prnu_ > 0.0F) {
    const std::uint64_t counter = ~key_ + (static_cast<std::uint64_t>(row) << 18);
    for (int u = 0; u < count; u += kBatch) {
      std::uint64_t bits = mixed((counter + static_cast<std::uint64_t>(u)) * 0x9e3779b97f4a7c15ULL);
      const int end = std::min(u + kBatch, count);
      for (int i = u; i < end; ++i, bits >>= 16)
        light_e[i] = black_level_e_ + (light_e[i] - black_level_e_) *
                                          (1.0F + prnu_ * normal_[bits & (kNormals - 1)]);
    }
  }
  if (!noisy_) return;
  const std::uint64_t counter =
      key_ + ((static_cast<std::uint64_t>(frame) << 36) | (static_cast<std::uint64_t>(row) << 18));
  for (int u = 0; u < count; u += kBatch) {
    std::uint64_t bits = mixed((counter + static_cast<std::uint64_t>(u)) * 0x9e3779b97f4a7c15ULL);
    const int end = std::min(u + kBatch, count);
    for (int i = u; i < end; ++i, bits >>= 16) {
      const float mean_e = light_e[i];
      const float sigma_e = std::sqrt(shot_ * std::max(mean_e, 0.0F) + fixed_variance_e2_);
      light_e[i] = mean_e + sigma_e * normal_[bits & (kNormals - 1)];
    }
  }
}

void Sensor::encode_row(const float* exposed_e, int count, std::uint8_t* codes) const {
  const auto scale = static_cast<float>(kShares / full_well_e_);
  for (int u = 0; u < count; ++u) {
    const float place = std::clamp(exposed_e[u] * scale + 0.5F, 0.0F, static_cast<float>(kShares));
    codes[u] = codes_[static_cast<std::size_t>(static_cast<std::uint32_t>(place))];
  }
}

double Sensor::fraction(double light_e) const {
  const double place = std::clamp(light_e / full_well_e_, 0.0, 1.0) * kShares;
  return static_cast<double>(fractions_[static_cast<std::size_t>(place + 0.5)]);
}

double Sensor::green_deficit(double red_excess_e, double blue_excess_e) {
  return (kRed * red_excess_e + kBlue * blue_excess_e) / kGreen;
}

Sensor::Chroma Sensor::chroma(double luminance_e, double red_excess_e, double blue_excess_e) const {
  return codes_of(luminance_e + red_excess_e,
                  luminance_e - green_deficit(red_excess_e, blue_excess_e),
                  luminance_e + blue_excess_e)
      .chroma;
}

Sensor::Codes Sensor::codes_of(double red_e, double green_e, double blue_e) const {
  const double red = fraction(red_e), green = fraction(green_e), blue = fraction(blue_e);
  const double luma = kRed * red + kGreen * green + kBlue * blue;
  const auto code = [](double difference) {
    return static_cast<std::uint8_t>(
        std::clamp(std::lround(128.0 + 224.0 * difference), 16L, 240L));
  };
  return {static_cast<std::uint8_t>(std::lround(kBlackCode + (kWhiteCode - kBlackCode) * luma)),
          {code((blue - luma) / (2.0 * (1.0 - kBlue))), code((red - luma) / (2.0 * (1.0 - kRed)))}};
}

}  // namespace vildar
