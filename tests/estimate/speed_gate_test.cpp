#include "estimate/speed_gate.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"

namespace vildar {
namespace {

/// Slope of a line through places at unit times in [first, last) with unit white noise.
PartSpeed slope_of(const std::vector<double>& places, int first, int last) {
  const double middle = 0.5 * (first + last - 1);
  double across = 0.0, along = 0.0;
  for (int k = first; k < last; ++k) {
    across += (k - middle) * places[static_cast<std::size_t>(k)];
    along += (k - middle) * (k - middle);
  }
  return {across / along, 1.0 / std::sqrt(along)};
}

/// Share of 4000 noisy lines of 40 places of which two parts exclude each other. From `bend` on the
/// slope is greater by `excess` sigmas of the difference of the fits to [0, 40) and to [0, `last`).
double excluded(int first, int last, int bend, double excess, bool nested) {
  constexpr int kPlaces = 40, kTrials = 4000;
  std::vector<double> places(kPlaces, 0.0);
  const PartSpeed whole = slope_of(places, 0, kPlaces), part = slope_of(places, first, last);
  std::vector<double> bent(kPlaces, 0.0);
  for (int k = bend; k < kPlaces; ++k) bent[static_cast<std::size_t>(k)] = k - bend;
  const double per_slope =
      std::abs(slope_of(bent, 0, kPlaces).speed_mps - slope_of(bent, first, last).speed_mps);
  const double sigma =
      std::sqrt(part.sigma_mps * part.sigma_mps - whole.sigma_mps * whole.sigma_mps);
  const double slope = excess == 0.0 ? 0.0 : excess * sigma / per_slope;
  Random random(11);
  int found = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    for (int k = 0; k < kPlaces; ++k)
      places[static_cast<std::size_t>(k)] =
          0.7 * k + slope * bent[static_cast<std::size_t>(k)] + random.normal(0.0, 1.0);
    found += exclude_each_other(slope_of(places, 0, kPlaces), slope_of(places, first, last), nested)
                 ? 1
                 : 0;
  }
  return static_cast<double>(found) / kTrials;
}

TEST(SpeedGate, PartsOfOneLineDoNotExcludeEachOther) {
  for (const int last : {20, 27, 30}) EXPECT_LT(excluded(0, last, 0, 0.0, true), 0.003) << last;
}

TEST(SpeedGate, ALongPartIsHeldAgainstWhatItHolds) {
  // Three quarters: the variance of the difference is 1.37 of the whole's, that of strangers 3.37.
  EXPECT_GT(excluded(0, 30, 25, 5.0, true), 0.9);
  EXPECT_LT(excluded(0, 30, 25, 5.0, false), 0.5);
}

}  // namespace
}  // namespace vildar
