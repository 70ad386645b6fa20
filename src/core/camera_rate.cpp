#include "core/camera_rate.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace vildar {

bool is_camera_rate(double rate_hz, double off) {
  constexpr std::array kRates_hz{10.0, 12.0, 12.5, 15.0, 20.0,  24.0,  25.0,  30.0,
                                 48.0, 50.0, 60.0, 90.0, 100.0, 120.0, 200.0, 240.0};
  constexpr double kTelevision = 1000.0 / 1001.0;
  return std::ranges::any_of(kRates_hz, [&](double one_hz) {
    return std::abs(rate_hz / one_hz - 1.0) < off ||
           std::abs(rate_hz / (kTelevision * one_hz) - 1.0) < off;
  });
}

}  // namespace vildar
