#include "synth/sensor.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "scenes.h"
#include "synth/bayer.h"

namespace vildar {
namespace {

CameraSite linear_camera() {
  CameraSite camera = *small_scene().site.camera;
  camera.response = ResponseKind::linear;
  return camera;
}

struct Moments {
  double mean = 0.0, variance = 0.0;
};

// Codes of flat fields of `light_e`, `rows` rows of 4096 pixels.
Moments codes_of_flat(const Sensor& sensor, float light_e, int rows) {
  std::vector<float> row(4096);
  std::vector<std::uint8_t> codes(row.size());
  double sum = 0.0, square = 0.0;
  for (int v = 0; v < rows; ++v) {
    std::fill(row.begin(), row.end(), light_e);
    sensor.expose_row(row.data(), 4096, 1, v);
    sensor.encode_row(row.data(), 4096, codes.data());
    for (const std::uint8_t code : codes) {
      sum += code - 100;
      square += (code - 100) * (code - 100);
    }
  }
  const double count = 4096.0 * rows;
  return {sum / count + 100 - 16, square / count - sum / count * (sum / count)};
}

TEST(Sensor, PhotonTransferGivesTheGain) {
  constexpr double kRelative = 1e-3;
  constexpr int kRows = 8000;
  ImageScene image;
  image.full_well_e = 500.0;
  image.read_noise_e = 3.0;
  const Sensor sensor(image, linear_camera(), 0.0, 5);
  const Moments low = codes_of_flat(sensor, 40.0F, kRows);
  const Moments high = codes_of_flat(sensor, 340.0F, kRows);
  // Rounding adds 1 / 12 to both. The two fields have the same deviates, so that both variances,
  // and with them the slope, are off by the same share: sqrt(2 / N), a quarter of the tolerance.
  ASSERT_LT(4.0 * std::sqrt(2.0 / (4096.0 * kRows)), kRelative);
  const double gain = (high.variance - low.variance) / (high.mean - low.mean);
  EXPECT_NEAR(gain / (219.0 / 500.0), 1.0, kRelative);
  RecordProperty("gain_error_ppm",
                 static_cast<int>(std::lround(1e6 * (gain * 500.0 / 219.0 - 1.0))));
}

TEST(Sensor, DarkCurrentAddsItsShotNoise) {
  constexpr int kRows = 400;
  ImageScene image;
  image.full_well_e = 500.0;
  image.read_noise_e = 3.0;
  image.shot_noise = false;
  image.dark_e_per_s = 4000.0;
  const Sensor sensor(image, linear_camera(), 0.02, 5);
  const double gain = 219.0 / 500.0;
  const Moments flat = codes_of_flat(sensor, 250.0F, kRows);
  EXPECT_NEAR((flat.variance - 1.0 / 12.0) / (gain * gain * (9.0 + 80.0)), 1.0,
              4.5 * std::sqrt(2.0 / (4096.0 * kRows)));
  EXPECT_NEAR(flat.mean, gain * 250.0, 0.02) << "its mean is taken off";
}

TEST(Sensor, PrnuScalesLightAndStaysFromFrameToFrame) {
  ImageScene image;
  image.shot_noise = false;
  image.read_noise_e = 0.0;
  image.black_level_e = 20.0;
  image.prnu = 0.01;
  const Sensor sensor(image, linear_camera(), 0.0, 5);
  std::vector<float> first(40'000, 1020.0F), second(40'000, 2020.0F);
  sensor.expose_row(first.data(), 40'000, 1, 3);
  sensor.expose_row(second.data(), 40'000, 2, 3);
  double square = 0.0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const double off = (static_cast<double>(first[i]) - 20.0) / 1000.0 - 1.0;
    square += off * off;
    ASSERT_NEAR((static_cast<double>(second[i]) - 20.0) / 2000.0 - 1.0, off, 1e-5);
  }
  EXPECT_NEAR(std::sqrt(square / 40'000.0) / 0.01, 1.0, 4.5 / std::sqrt(2.0 * 40'000.0));
}

TEST(Demosaic, GivesFlatColoursAndRampsBack) {
  constexpr int kWidth = 12, kHeight = 10;
  // Bilinear interpolation is exact for light that is linear over the image, off the border.
  const auto colour_at = [](int colour, int u, int v) {
    return 100.0F * static_cast<float>(colour + 1) + 3.0F * static_cast<float>(u) -
           2.0F * static_cast<float>(v);
  };
  std::vector<float> mosaic;
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) mosaic.push_back(colour_at(bayer_colour(u, v), u, v));
  const auto planes = demosaic(mosaic, kWidth, kHeight);
  for (int v = 1; v < kHeight - 1; ++v)
    for (int u = 1; u < kWidth - 1; ++u)
      for (std::size_t colour = 0; colour < 3; ++colour)
        EXPECT_NEAR(planes[colour][static_cast<std::size_t>(v * kWidth + u)],
                    colour_at(static_cast<int>(colour), u, v), 1e-4F);
}

}  // namespace
}  // namespace vildar
