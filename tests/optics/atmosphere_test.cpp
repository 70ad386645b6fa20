#include "optics/atmosphere.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace vildar {
namespace {

TEST(Atmosphere, LightFallsByTheSameFactorEveryMetre) {
  EXPECT_EQ(transmittance(0.0, Metres(1e4)), 1.0);
  EXPECT_NEAR(transmittance(std::log(2.0), Metres(3.0)), 0.125, 1e-15);
  EXPECT_NEAR(transmittance(0.02, Metres(30.0)),
              transmittance(0.02, Metres(10.0)) * transmittance(0.02, Metres(20.0)), 1e-15);
}

TEST(Atmosphere, VisibilityIsWhereTwoPerCentOfContrastAreLeft) {
  EXPECT_NEAR(transmittance(extinction_from_visibility_per_m(Metres(350.0)), Metres(350.0)), 0.02,
              1e-5);
  // 100 m of visibility cost 8.5 dB in 50 m, 1 km costs 0.85 dB.
  EXPECT_NEAR(10.0 * std::log10(transmittance(extinction_from_visibility_per_m(Metres(100.0)),
                                              Metres(50.0))),
              -8.5, 0.01);
}

TEST(Atmosphere, AMillimetreOfRainAnHourCostsOneDecibelAKilometre) {
  EXPECT_NEAR(-10.0 * std::log10(transmittance(extinction_of_rain_per_m(1.0), Metres(1000.0))),
              1.076, 1e-12);
  // A thousand times the rain: 1000^0.67 times the decibels.
  EXPECT_NEAR(extinction_of_rain_per_m(20.0) / extinction_of_rain_per_m(0.02),
              std::pow(1000.0, 0.67), 1e-9);
  EXPECT_EQ(extinction_of_rain_per_m(0.0), 0.0);
}

TEST(Atmosphere, NonsenseIsRefused) {
  EXPECT_THROW(transmittance(-1e-3, Metres(1.0)), std::domain_error);
  EXPECT_THROW(transmittance(1e-3, Metres(std::nan(""))), std::domain_error);
  EXPECT_THROW(extinction_from_visibility_per_m(Metres(0.0)), std::domain_error);
  EXPECT_THROW(extinction_of_rain_per_m(-1.0), std::domain_error);
}

}  // namespace
}  // namespace vildar
