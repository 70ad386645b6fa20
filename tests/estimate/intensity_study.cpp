#include <cmath>
#include <cstdio>

#include "core/clock.h"
#include "core/quantity.h"
#include "estimate/vehicle.h"
#include "simulated_beam.h"
#include "study.h"

namespace vildar {
namespace {

constexpr int kTrials = 1000;

struct Case {
  const char* name;
  double height_std_m = 0.1, separation_std_m = 0.15, lateral_std_m = 0.3;
  double acceleration_std_mps2 = 1.5;
  double from_m = 60.0, way_m = 50.0, seen_s = INFINITY;  // until the one or the other is over
  double frame_rate_hz = 30.0, sigma_px = 0.2, yaw_std_rad = 0.0;
  bool single_lamp = false;
};

Site site_of(const Case& tried) {
  Site site = simulated::mast_site(4.0);
  site.lamps.height_m->std = tried.height_std_m;
  site.lamps.separation_m->std = tried.separation_std_m;
  site.road.lanes.front().lateral_m.std = tried.lateral_std_m;
  site.camera->yaw_rad.std = tried.yaw_std_rad;
  // The camera's intensity, as the power of a sensor where the camera is, on the camera's clock.
  PhotodiodeSite& sensor = site.photodiodes.emplace_back();
  sensor.position_m = site.camera->position_m;
  sensor.half_field_of_view_rad = 0.5 * kPi;
  site.mains_hz = 200.0;  // blocks shorter than a frame: each holds one
  return site;
}

// Light of both lamps in each frame; noise as of unclipped or fitted lamps of a lossless clip.
PowerTrace intensity_of(const VehicleTrack& track, const simulated::Vehicle& vehicle,
                        const Site& site, const simulated::Beam& beam, double frame_rate_hz,
                        Random& random) {
  constexpr double kRelative = 0.003, kOfFirst = 0.005;
  const Eigen::Vector3d camera_m = Camera(*site.camera).position_m();
  const double first = simulated::beam_power(vehicle, site.road, beam, camera_m, 0.0);
  PowerTrace trace;
  trace.sample_period_s = 1.0 / frame_rate_hz;
  trace.noise_sigma_w = kOfFirst * first;
  for (const VehicleSighting& sighting : track.sightings) {
    const double t_s = seconds_of(sighting.time);
    const double light = simulated::beam_power(vehicle, site.road, beam, camera_m, t_s);
    trace.time_s.push_back(t_s);
    trace.power_w.push_back(static_cast<float>(light * (1.0 + kRelative * random.normal()) +
                                               kOfFirst * first * random.normal()));
  }
  return trace;
}

struct Errors {
  double square = 0.0, variance = 0.0;
  int covered = 0;

  void add(const SpeedEstimate& speed, const simulated::Vehicle& vehicle) {
    const double truth_mps = vehicle.speed_at_mps(speed.time_s);
    square += std::pow(speed.speed_mps / truth_mps - 1.0, 2);
    variance += std::pow(speed.std_mps / speed.speed_mps, 2);
    covered += speed.lo95_mps <= truth_mps && truth_mps <= speed.hi95_mps;
  }
};

using IntensityStudy = Study;

// What the camera's own intensity adds to its bearings: nothing that could be measured.
TEST_F(IntensityStudy, AddsNothingToBearingsAndDoesNotHurt) {
  constexpr double kSlack = 0.0207;  // three binomial sigmas of 95 %
  constexpr double kYaw_rad = 0.01;
  const double known_m = 0.01;
  for (const Case& tried :
       {Case{.name = "whole pass"}, Case{.name = "0.4 s from 35 m", .from_m = 35.0, .seen_s = 0.4},
        Case{.name = "single lamp", .single_lamp = true},
        Case{.name = "2 px, 10 Hz, yaw +- 10 mrad",
        .frame_rate_hz = 10.0,
        .sigma_px = 2.0,
        .yaw_std_rad = kYaw_rad},
        Case{.name = "lengths known",
        .height_std_m = known_m,
        .separation_std_m = known_m,
        .lateral_std_m = known_m},
        Case{.name = "lengths known, 0.4 s from 35 m",
        .height_std_m = known_m,
        .separation_std_m = known_m,
        .lateral_std_m = known_m,
        .from_m = 35.0,
        .seen_s = 0.4},
        Case{.name = "lengths known, single lamp, 2 px, 10 Hz, yaw +- 10 mrad",
        .height_std_m = known_m,
        .lateral_std_m = known_m,
        .frame_rate_hz = 10.0,
        .sigma_px = 2.0,
        .yaw_std_rad = kYaw_rad,
        .single_lamp = true}})
    for (const double ripple : {0.1, 0.3}) {
      Random random(20260171);
      Site site = site_of(tried);
      Errors bearings, both;
      int used = 0, fused = 0;
      for (int i = 0; i < kTrials; ++i) {
        simulated::Vehicle vehicle;
        vehicle.along_m = tried.from_m;
        vehicle.speed_mps = random.uniform(8.0, 35.0);
        vehicle.acceleration_mps2 = random.normal(0.0, tried.acceleration_std_mps2);
        vehicle.lateral_m = random.normal(-4.0, tried.lateral_std_m);
        vehicle.height_m = random.normal(0.65, tried.height_std_m);
        vehicle.separation_m = tried.single_lamp ? 0.0 : random.normal(1.2, tried.separation_std_m);
        site.camera->yaw_rad.mean = 0.0;
        const simulated::View view{.to_s = std::min(tried.seen_s, tried.way_m / vehicle.speed_mps),
                                   .frame_rate_hz = tried.frame_rate_hz,
                                   .sigma_px = tried.sigma_px,
                                   .single_lamp = tried.single_lamp};
        const VehicleTrack track = simulated::track_of(vehicle, site, view, random);
        const simulated::Beam beam = simulated::random_beam(ripple, random);
        const PowerTrace trace =
            intensity_of(track, vehicle, site, beam, tried.frame_rate_hz, random);
        site.camera->yaw_rad.mean = random.normal(0.0, tried.yaw_std_rad);
        const VehiclePower power{&trace, false};
        const VehicleResult result = estimate_vehicle(track, site, {&power, 1}).result;
        if (result.withheld) continue;
        ++used;
        fused += result.method == Method::fused;
        both.add(result.speed, vehicle);
        for (const MethodResult& row : result.methods)
          if (row.method == Method::geometry_camera)
            bearings.add(std::get<SpeedEstimate>(row.speed), vehicle);
      }
      const double n = used, ratio = std::sqrt(both.square / bearings.square);
      std::printf(
          "%s, beam off by %.1f nat: used %d, fused %d, rmse %.2f %% of bearings, %.2f %% with "
          "intensity, ratio %.3f, of sigmas %.3f, coverage %.3f and %.3f\n",
          tried.name, ripple, used, fused, 100.0 * std::sqrt(bearings.square / n),
          100.0 * std::sqrt(both.square / n), ratio, std::sqrt(both.variance / bearings.variance),
          bearings.covered / n, both.covered / n);
      std::fflush(stdout);
      EXPECT_LE(ratio, 1.1);
      EXPECT_GE(both.covered / n, 0.95 - kSlack);
    }
}

}  // namespace
}  // namespace vildar
