// What one photodiode beside a camera can add at most: Cramer-Rao bounds of the speed (Bayesian in
// what has a prior) from bearings and power, by a model that shares no code with the estimators.

#include <array>
#include <cmath>
#include <cstdio>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include "core/quantity.h"

namespace vildar {
namespace {

enum Unknown : int {
  kSpeed,
  kAcceleration,
  kAhead,
  kAside,
  kBelow,
  kApart,
  kTurned,
  kTilted,
  kLogGain,
  kWidth,
  kFall,
  kAmbient,
  kWaves,
  kUnknowns = kWaves + 6,
};
using Jet = ceres::Jet<double, kUnknowns>;
using Row = Eigen::Matrix<double, kUnknowns, 1>;
using Information = Eigen::Matrix<double, kUnknowns, kUnknowns>;

struct Setting {
  double camera_height_m = 4.0;
  bool photodiode = true;
  double ripple_nat = 0.0;  // of the k-th cosine the k-th part
  bool ambient_known = true;
};

// A vehicle of 20 m/s from 60 to 10 m, its lamps at 0.65 m, 1.2 m apart and 4 m aside; bearings of
// 0.2 px at 1400 px, 30 Hz; power at 1 kHz, 40 dB at 60 m. Known beforehand: the height of the
// camera over the lamps, yaw and pitch to 0.5 mrad, the acceleration to 3 m/s^2; of the beam that
// it falls by 11.4 +- 5.7 nat/rad^2 of azimuth and 9 +- 6 nat/rad of elevation, and its cosines.
class Bound {
 public:
  explicit Bound(const Setting& setting) : setting_(setting) {
    const std::array<double, kUnknowns> truth{
        20.0, 0.0, 35.0, 4.0, setting.camera_height_m - 0.65, 1.2, 0.0, 0.0, 0.0, 11.4, 9.0, 0.0};
    for (int i = 0; i < kUnknowns; ++i)
      values_[static_cast<std::size_t>(i)] = Jet(truth[static_cast<std::size_t>(i)], i);
    constexpr double kHalf_s = 1.25;
    for (int frame = 0; frame < 75; ++frame) add_bearings(frame / 30.0 - kHalf_s);
    if (setting.photodiode) {
      noise_ = 0.01 * power(-kHalf_s).a;
      for (int sample = 0; sample < 2500; ++sample) add(power(1e-3 * sample - kHalf_s), noise_);
    }
    add_priors();
  }

  double relative_speed() const {
    const Row scale = information_.diagonal().cwiseSqrt().cwiseInverse();
    const Information scaled = scale.asDiagonal() * information_ * scale.asDiagonal();
    const Row of_speed = scaled.ldlt().solve(Row::Unit(kSpeed));
    return scale[kSpeed] * std::sqrt(of_speed[kSpeed]) / values_[kSpeed].a;
  }

 private:
  Jet ahead(double time_s) const {
    return values_[kAhead] - time_s * (values_[kSpeed] + 0.5 * time_s * values_[kAcceleration]);
  }
  void add(const Jet& seen, double std) {
    information_ += seen.v * seen.v.transpose() / (std * std);
  }
  void add_bearings(double time_s) {
    constexpr double kStd_rad = 0.2 / 1400.0;
    for (const double side : {-0.5, 0.5}) {
      const Jet aside = values_[kAside] + side * values_[kApart], along = ahead(time_s);
      add(atan2(aside, along) + values_[kTurned], kStd_rad);
      add(atan2(values_[kBelow], sqrt(along * along + aside * aside)) + values_[kTilted], kStd_rad);
    }
  }
  Jet power(double time_s) const {
    Jet sum(0.0);
    for (const double side : {-0.5, 0.5}) {
      const Jet aside = values_[kAside] + side * values_[kApart], along = ahead(time_s);
      const Jet distance2 = along * along + aside * aside + values_[kBelow] * values_[kBelow];
      const Jet azimuth = atan2(aside, along);
      Jet log_light = values_[kLogGain] - values_[kWidth] * azimuth * azimuth -
                      values_[kFall] * atan2(values_[kBelow], sqrt(along * along + aside * aside));
      for (int k = 0; k < 6; ++k)
        log_light +=
            values_[static_cast<std::size_t>(kWaves + k)] * cos((k + 1) * kPi / 0.45 * azimuth);
      sum += 500.0 * exp(log_light) * along / (distance2 * sqrt(distance2));
    }
    return sum + values_[kAmbient];
  }
  void add_priors() {
    const auto known = [&](int unknown, double std) {
      information_(unknown, unknown) += 1.0 / (std * std);
    };
    known(kBelow, 1e-4);
    known(kTurned, 0.5e-3);
    known(kTilted, 0.5e-3);
    known(kAcceleration, 3.0);
    known(kLogGain, 1e3);
    known(kWidth, 5.7);
    known(kFall, 6.0);
    const double dark = setting_.photodiode ? noise_ : 1.0;
    known(kAmbient, setting_.ambient_known ? 1e-4 * dark : 1e4 * dark);
    for (int k = 0; k < 6; ++k) known(kWaves + k, std::max(1e-6, setting_.ripple_nat / (k + 1)));
  }

  Setting setting_;
  std::array<Jet, kUnknowns> values_;
  double noise_ = 1.0;
  Information information_ = Information::Zero();
};

double percent(const Setting& setting) { return 100.0 * Bound(setting).relative_speed(); }

TEST(FusionBound, ABeamOfOneFamilyAndAKnownAmbientTellTheAcceleration) {
  constexpr double kTolerance = 0.002;
  EXPECT_NEAR(percent({.camera_height_m = 1.5, .photodiode = false}), 0.289, kTolerance);
  EXPECT_NEAR(percent({.camera_height_m = 1.5}), 0.168, kTolerance);
  EXPECT_NEAR(percent({.camera_height_m = 4.0, .photodiode = false}), 0.273, kTolerance);
  EXPECT_NEAR(percent({.camera_height_m = 4.0}), 0.179, kTolerance);
}

// So a photodiode beside the camera has no say in the trajectory where lamps differ from any law by
// a hundredth.
TEST(FusionBound, ABeamThatRipplesByAHundredthTellsNothing) {
  for (const double height_m : {1.5, 4.0}) {
    const double camera = percent({.camera_height_m = height_m, .photodiode = false});
    for (const double ripple_nat : {0.001, 0.003, 0.01, 0.1})
      std::printf(
          "camera at %.1f m: %.3f %%; ripple of %.3f nat: %.3f, ambient unknown: %.3f %%\n",
          height_m, camera, ripple_nat,
          percent({.camera_height_m = height_m, .ripple_nat = ripple_nat}),
          percent({.camera_height_m = height_m, .ripple_nat = ripple_nat, .ambient_known = false}));
    EXPECT_GT(percent({.camera_height_m = height_m, .ripple_nat = 0.01}), 0.96 * camera);
    EXPECT_GT(percent({.camera_height_m = height_m, .ripple_nat = 0.1}), 0.99 * camera);
    EXPECT_GT(percent({.camera_height_m = height_m, .ripple_nat = 0.003, .ambient_known = false}),
              0.94 * camera);
  }
}

}  // namespace
}  // namespace vildar
