#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "estimate/vehicle.h"
#include "simulated_power.h"
#include "study.h"

namespace vildar {
namespace {

constexpr int kTrials = 100;

// Two lamps whose beam is a Gaussian in azimuth, exponential in elevation, with up to `ripple` nat
// of cosines; 40 dB above the noise at the start, on a background half as strong as the start.
PowerTrace beam_trace(const simulated::Vehicle& vehicle, const Site& site, double ripple,
                      double time_offset_s, Random& random) {
  const auto& place = site.photodiodes.front().position_m;
  const Eigen::Vector3d receiver_m(place[0].mean, place[1].mean, place[2].mean);
  const double width = random.normal(11.4, 2.5), tilt = random.normal(9.0, 3.0);
  std::array<double, 6> waves;
  for (std::size_t k = 0; k < waves.size(); ++k)
    waves[k] = ripple * random.normal() / static_cast<double>(k + 1);
  const auto power_w = [&](double t_s) {
    const simulated::Lamps lamps = simulated::lamps_at(vehicle, site.road, t_s);
    double sum_w = 0.0;
    for (const Eigen::Vector3d& lamp_m : {lamps.left_m, lamps.right_m}) {
      const Eigen::Vector3d apart_m = lamp_m - receiver_m;
      if (apart_m.x() <= 0.0) continue;
      const double azimuth_rad = std::atan2(apart_m.y(), apart_m.x());
      const double elevation_rad = std::atan2(-apart_m.z(), std::hypot(apart_m.x(), apart_m.y()));
      double log_intensity = -width * azimuth_rad * azimuth_rad - tilt * elevation_rad;
      for (std::size_t k = 0; k < waves.size(); ++k)
        log_intensity += waves[k] * std::cos(static_cast<double>(k + 1) * kPi * azimuth_rad / 0.45);
      sum_w += 0.5 * std::exp(log_intensity) * apart_m.x() / std::pow(apart_m.norm(), 3);
    }
    return sum_w;
  };
  PowerTrace trace;
  trace.sample_period_s = 1e-3;
  trace.noise_sigma_w = power_w(0.0) / 100.0;
  trace.ambient_w = 0.5 * power_w(0.0);
  for (double t_s = -0.5; vehicle.along_at_m(t_s) > -5.0 && t_s < 8.0; t_s += 1e-3) {
    trace.time_s.push_back(t_s - time_offset_s);
    trace.power_w.push_back(
        static_cast<float>(power_w(t_s) + trace.ambient_w + trace.noise_sigma_w * random.normal()));
  }
  return trace;
}

struct Found {
  double camera2 = 0.0, fused2 = 0.0;  // squared relative errors, summed
  int covered = 0, fused = 0, used = 0;
};

Found study(double camera_height_m, double ripple) {
  Random random(20260104);
  Site site = simulated::mast_site(camera_height_m);
  site.photodiodes.resize(1);
  site.photodiodes[0].position_m = site.camera->position_m;
  site.photodiodes[0].time_offset_s.std = 0.002;
  Found study;
  for (int i = 0; i < kTrials; ++i) {
    simulated::Vehicle vehicle;
    vehicle.speed_mps = random.uniform(8.0, 35.0);
    vehicle.acceleration_mps2 = random.normal(0.0, 1.5);
    vehicle.lateral_m = random.normal(-4.0, 0.3);
    vehicle.height_m = random.normal(0.65, 0.1);
    vehicle.separation_m = random.normal(1.2, 0.15);
    const PowerTrace trace = beam_trace(vehicle, site, ripple, random.normal(0.0, 0.002), random);
    const simulated::View view{.to_s = 50.0 / vehicle.speed_mps};
    const VehicleTrack track = simulated::track_of(vehicle, site, view, random);
    const VehiclePower power{&trace, false};
    const VehicleResult camera = estimate_vehicle(track, site, {}).result;
    const VehicleResult both = estimate_vehicle(track, site, {&power, 1}).result;
    if (camera.withheld || both.withheld) continue;
    ++study.used;
    study.fused += both.method == Method::fused;
    const auto error = [&](const VehicleResult& result) {
      return result.speed.speed_mps / vehicle.speed_at_mps(result.speed.time_s) - 1.0;
    };
    study.camera2 += error(camera) * error(camera);
    study.fused2 += error(both) * error(both);
    const double truth_mps = vehicle.speed_at_mps(both.speed.time_s);
    study.covered += both.speed.lo95_mps <= truth_mps && truth_mps <= both.speed.hi95_mps;
  }
  return study;
}

using JointStudy = Study;

TEST_F(JointStudy, ABeamUnlikeTheModelDoesNotHurt) {
  constexpr double kCoverageSlack = 0.066;  // three binomial sigmas at 100 trials
  for (const double camera_height_m : {4.0, 1.5})
    for (const double ripple : {0.0, 0.1, 0.3}) {
      const Found found = study(camera_height_m, ripple);
      EXPECT_GE(found.used, kTrials * 95 / 100);
      EXPECT_GE(found.fused, kTrials * 9 / 10);
      EXPECT_LE(std::sqrt(found.fused2 / found.camera2), 1.03) << camera_height_m << " " << ripple;
      EXPECT_NEAR(found.covered / static_cast<double>(found.used), 0.95, kCoverageSlack);
    }
}

}  // namespace
}  // namespace vildar
