#include "estimate/power_model.h"

#include <ceres/jet.h>

#include <gtest/gtest.h>

#include "core/random.h"
#include "estimate/vector_math.h"
#include "optics/channel.h"
#include "optics/road.h"

namespace vildar {
namespace {

constexpr PowerParameter kAll[] = {kPowerSpeed,         kPowerRange,    kPowerLogGain,
                                   kPowerPerpendicular, kPowerExponent, kPowerAcceleration,
                                   kPowerRadius};

// The law written out with the road's own geometry; T may be a Jet.
template <class T>
T power_of(const T* p, const PowerSetting& setting, double t_s) {
  const T along_m = p[kPowerRange] - t_s * (p[kPowerSpeed] + 0.5 * t_s * p[kPowerAcceleration]);
  PathPoint<T> place{along_m, p[kPowerPerpendicular], T(0.0)};
  if (setting.curved) {
    place = path_point(along_m, T(0.0), 1.0, setting.straight_m, p[kPowerRadius]);
    place.y_m += p[kPowerPerpendicular];
  }
  const T distance_m =
      sqrt(place.x_m * place.x_m + place.y_m * place.y_m + setting.height_m * setting.height_m);
  T power = exp(p[kPowerLogGain]) * pow(distance_m, -p[kPowerExponent]);
  if (setting.cosine_exponent > 0.0) power *= pow(place.x_m / distance_m, setting.cosine_exponent);
  return power;
}

TEST(PowerModel, PowerAndDerivativesAreThoseOfAutomaticDifferentiation) {
  constexpr double kRelative = 1e-10;
  using Jet = ceres::Jet<double, kPowerParameters>;
  Random random(3);
  PowerCurve curve;
  for (int trial = 0; trial < 200; ++trial) {
    PowerSetting setting;
    setting.cosine_exponent = trial % 2 == 0 ? 0.0 : random.uniform(1.0, 8.0);
    setting.curved = trial % 3 == 0;
    setting.straight_m = setting.curved && trial % 2 == 0 ? 4.0 : 0.0;
    setting.height_m = trial % 5 == 0 ? 3.0 : 0.0;
    PowerVector p;
    p << random.uniform(5.0, 40.0), random.uniform(10.0, 40.0), random.uniform(-12.0, 1.0),
        random.uniform(0.3, 6.0), random.uniform(1.0, 3.0), random.uniform(-4.0, 4.0),
        random.uniform(30.0, 200.0);
    const std::vector<double> times_s{-0.1, 0.0, 0.1, 0.17, 0.23};
    curve.differentiate(p, setting, times_s, kAll);
    Jet jets[kPowerParameters];
    for (int i = 0; i < kPowerParameters; ++i) jets[i] = Jet(p[i], i);
    for (std::size_t i = 0; i < times_s.size(); ++i) {
      const Jet truth = power_of(jets, setting, times_s[i]);
      EXPECT_NEAR(curve.power_w()[i] / truth.a, 1.0, kRelative);
      for (int c = 0; c < kPowerParameters; ++c)
        EXPECT_NEAR(curve.column(static_cast<std::size_t>(c))[i], truth.v[c],
                    kRelative * (truth.v.cwiseAbs().maxCoeff()))
            << "trial " << trial << " parameter " << symbol_of(kAll[c]);
    }
  }
}

TEST(PowerModel, BehindTheLampThereIsNoLight) {
  PowerVector p = PowerVector::Zero();
  p << 20.0, 1.0, 0.0, 0.5, 1.21, 0.0, 1.0;
  PowerCurve curve;
  const std::vector<double> times_s{0.0, 0.1};
  PowerSetting setting;
  setting.cosine_exponent = 3.6;
  curve.differentiate(p, setting, times_s, kAll);
  EXPECT_GT(curve.power_w()[0], 0.0);
  EXPECT_EQ(curve.power_w()[1], 0.0);
  for (std::size_t c = 0; c < kPowerParameters; ++c) EXPECT_EQ(curve.column(c)[1], 0.0);
  setting.cosine_exponent = 0.0;
  curve.evaluate(p, setting, times_s);
  EXPECT_NEAR(curve.power_w()[1], (PowerLaw{1.0, 1.21, 0.0}.power_w(-1.0, 0.5)), 1e-12);
}

TEST(VectorMath, TheArctangentOfInfinityIsARightAngle) {
  std::vector<double> values{INFINITY, -INFINITY};
  arctangents(values, values);
  EXPECT_DOUBLE_EQ(values[0], 0.5 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(values[1], -0.5 * std::numbers::pi);
}

TEST(VectorMath, AgreesWithTheStandardLibraryAtEveryLength) {
  constexpr double kUlps = 8.0 * 2.2e-16;
  Random random(5);
  for (std::size_t n = 0; n < 40; ++n) {
    std::vector<double> values(n), logs(n), exponents(n);
    for (double& value : values) value = std::exp(random.uniform(-300.0, 300.0));
    natural_logs(values, logs);
    for (std::size_t i = 0; i < n; ++i)
      EXPECT_NEAR(logs[i], std::log(values[i]), kUlps * std::max(1.0, std::abs(logs[i])));
    exponentials(logs, exponents);
    for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(exponents[i] / std::exp(logs[i]), 1.0, kUlps);
    std::vector<double> angles(n), sine(n), cosine(n);
    arctangents(logs, angles);
    for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(angles[i], std::atan(logs[i]), kUlps);
    for (double& angle : angles) angle *= random.uniform(0.0, 20.0);
    sines(angles, sine);
    cosines(angles, cosine);
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_NEAR(sine[i], std::sin(angles[i]), kUlps);
      EXPECT_NEAR(cosine[i], std::cos(angles[i]), kUlps);
    }
  }
}

}  // namespace
}  // namespace vildar
