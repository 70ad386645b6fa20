#include "optics/ego_trace.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Core>
#include <Eigen/QR>

#include "core/random.h"

namespace vildar {
namespace {

constexpr double kSampled_s = 0.1, kSpeedNoise_mps = 0.04;
constexpr TimeSpan kWatched{2.0, 5.5};

double no_noise(double) { return 0.0; }

// Brakes from 20 m/s at 3 m/s^2, softly set in, from 3 s on.
double braking_mps(double t_s) {
  constexpr double kSoft_s = 0.4;
  return 20.0 - 3.0 * kSoft_s * std::log1p(std::exp((t_s - 3.0) / kSoft_s));
}

template <class Speed, class Noise>
std::vector<EgoSample> drive(const Speed& speed_mps, Noise noise_mps, double step_s = kSampled_s) {
  std::vector<EgoSample> trace;
  for (double t_s = 0.0; t_s < 8.0; t_s += step_s)
    trace.push_back({t_s, speed_mps(t_s) + noise_mps(t_s), 0.0});
  return trace;
}

// Root mean square over the watch of the way that the errors of the speeds add up to, about a
// parabola: speed and acceleration of another vehicle are unknown.
double stray_way_m(const std::vector<EgoSample>& trace, double (*speed_mps)(double)) {
  std::vector<double> times_s, way_m;
  double sum_m = 0.0;
  for (const EgoSample& sample : trace) {
    if (sample.time_s < kWatched.from_s || sample.time_s > kWatched.to_s) continue;
    sum_m += kSampled_s * (sample.speed_mps - speed_mps(sample.time_s));
    times_s.push_back(sample.time_s);
    way_m.push_back(sum_m);
  }
  const auto n = static_cast<Eigen::Index>(times_s.size());
  Eigen::MatrixXd powers(n, 3);
  Eigen::VectorXd way(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t_s = times_s[static_cast<std::size_t>(i)] - 3.75;
    powers.row(i) << 1.0, t_s, t_s * t_s;
    way[i] = way_m[static_cast<std::size_t>(i)];
  }
  const Eigen::VectorXd left = way - powers * powers.colPivHouseholderQr().solve(way);
  return std::sqrt(left.squaredNorm() / static_cast<double>(n));
}

double steady_mps(double t_s) { return 17.5 + 0.02 * t_s; }

// Over 200 traces of a steady drive the way that noise adds up to is gone for the most part, and of
// one that brakes what is lost and what is left of it come to no more than half as much again.
TEST(WithoutSpeedNoise, LeavesTheWayThatWasDriven) {
  constexpr int kTrials = 200;
  for (double (*speed_mps)(double) : {steady_mps, braking_mps}) {
    Random random(7);
    double raw = 0.0, smooth = 0.0;
    for (int i = 0; i < kTrials; ++i) {
      const auto trace =
          drive(speed_mps, [&](double) { return kSpeedNoise_mps * random.normal(); });
      raw += std::pow(stray_way_m(trace, speed_mps), 2) / kTrials;
      smooth += std::pow(stray_way_m(without_speed_noise(trace, kWatched), speed_mps), 2) / kTrials;
    }
    EXPECT_LT(std::sqrt(smooth), (speed_mps == steady_mps ? 0.5 : 1.5) * std::sqrt(raw));
  }
}

TEST(WithoutSpeedNoise, LeavesWhatIsExactOrFewAsItIs) {
  const auto same = [](const std::vector<EgoSample>& trace) {
    const std::vector<EgoSample> after = without_speed_noise(trace, kWatched);
    for (std::size_t i = 0; i < trace.size(); ++i)
      EXPECT_NEAR(after[i].speed_mps, trace[i].speed_mps, 1e-9) << i;
    return after.size() == trace.size();
  };
  EXPECT_TRUE(same(drive(braking_mps, no_noise)));
  Random random(8);
  EXPECT_TRUE(same(drive(
      steady_mps, [&](double) { return kSpeedNoise_mps * random.normal(); }, 1.0)));
  EXPECT_TRUE(same({}));
}

}  // namespace
}  // namespace vildar
