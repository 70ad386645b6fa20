#pragma once

#include <cstdint>
#include <vector>

#include "optics/response.h"
#include "synth/scenario.h"

namespace vildar {

/// From electrons to 8-bit limited-range codes: noise, full well, response. The noise of a pixel
/// depends on seed, frame and place alone, not on the order of the calls. Thread-safe.
class Sensor {
 public:
  Sensor(const ImageScene& image, const CameraSite& camera, std::uint64_t seed);

  static constexpr int kBlackCode = 16, kWhiteCode = 235;

  /// Codes of one row; `light_e` (mean electrons, black level included) is overwritten.
  void expose_row(float* light_e, int count, std::int64_t frame, int row,
                  std::uint8_t* codes) const;

  struct Chroma {
    std::uint8_t cb = 128, cr = 128;
  };
  /// BT.709 chroma of a mean light: luminance, and the excess of red and blue over grey.
  Chroma chroma(double luminance_e, double red_excess_e, double blue_excess_e) const;

 private:
  double fraction(double light_e) const;

  double full_well_e_;
  float read_variance_e2_;
  float shot_;
  bool noisy_;
  std::uint64_t key_;
  std::vector<float> normal_;        ///< quantiles of the standard normal law
  std::vector<std::uint8_t> codes_;  ///< by linear share of the full well
  std::vector<float> fractions_;     ///< response, by linear share of the full well
};

}  // namespace vildar
