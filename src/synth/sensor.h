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
  /// `exposure_s` > 0 gathers the dark current.
  Sensor(const ImageScene& image, const CameraSite& camera, double exposure_s, std::uint64_t seed);

  static constexpr int kBlackCode = 16, kWhiteCode = 235;

  /// Turns the mean electrons of one row into those that one exposure gives, noise included and
  /// neither clipped nor rounded. The black level is part of them and is not affected by PRNU.
  void expose_row(float* light_e, int count, std::int64_t frame, int row) const;
  /// Codes of exposed electrons.
  void encode_row(const float* exposed_e, int count, std::uint8_t* codes) const;

  struct Chroma {
    std::uint8_t cb = 128, cr = 128;
  };
  /// Share of nominal white, after the response, in [0, 1].
  double fraction(double light_e) const;
  /// BT.709 chroma of a mean light: luminance, and the excess of red and blue over grey.
  Chroma chroma(double luminance_e, double red_excess_e, double blue_excess_e) const;

  /// How far green lies below luminance where red and blue exceed it.
  static double green_deficit(double red_excess_e, double blue_excess_e);
  struct Codes {
    std::uint8_t luma = kBlackCode;
    Chroma chroma;
  };
  /// Luma and chroma of one pixel of a colour image; nothing clipped beforehand.
  Codes codes_of(double red_e, double green_e, double blue_e) const;

 private:
  double full_well_e_;
  float fixed_variance_e2_;  ///< of read-out and dark current
  float black_level_e_;
  float prnu_;
  float shot_;
  bool noisy_;
  std::uint64_t key_;
  std::vector<float> normal_;        ///< quantiles of the standard normal law
  std::vector<std::uint8_t> codes_;  ///< by linear share of the full well
  std::vector<float> fractions_;     ///< response, by linear share of the full well
};

}  // namespace vildar
