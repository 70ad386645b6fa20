#pragma once

#include <cmath>
#include <vector>

#include "calib/photodiode/learn_clock.h"
#include "estimate/simulated_pass.h"

namespace vildar::simulated {

/// What the site file does not say, or says wrongly, and how photodiodes see.
struct RimWorld {
  double time_offset_s = 0.0;            ///< clip time less photodiode time
  std::vector<double> rim_off_rad{0.0};  ///< of each photodiode, more than the file says
  double rim_width_rad = 0.0;            ///< of the logistic by which light goes; 0: at once
  double half_view_rad = radians_from_degrees(65.0);
  double offset_std_s = 0.02;  ///< that the file states
  double rate_hz = 1000.0;
  double jitter = 0.0;       ///< of stamps, of a period: uniform, this wide
  double unseen_mps2 = 0.0;  ///< std of what the acceleration changes by when the camera is passed
  bool one_lamp = false;     ///< all light comes from the vehicle's middle
};

/// Passes that point into `traces`.
struct TimedPasses {
  Site site;
  std::vector<std::vector<PowerTrace>> traces;
  std::vector<TimedPass> passes;
};

/// Share of a lamp, a disc of 0.12 m across the vehicle, that a photodiode sees.
inline double seen_share(const Eigen::Vector3d& apart_m, const Eigen::Vector3d& axis,
                         double half_view_rad, double width_rad) {
  constexpr int kParts = 9;
  double sum = 0.0;
  for (int part = 0; part < kParts; ++part) {
    const double aside_m = 0.12 * ((part + 0.5) / kParts - 0.5);
    const Eigen::Vector3d at_m = apart_m + Eigen::Vector3d(0.0, aside_m, 0.0);
    const double angle_rad = std::acos(at_m.normalized().dot(axis));
    if (width_rad > 0.0)
      sum += 1.0 / (1.0 + std::exp((angle_rad - half_view_rad) / width_rad));
    else
      sum += angle_rad < half_view_rad ? 1.0 : 0.0;
  }
  return sum / kParts;
}

inline Eigen::Vector3d looks_along(const PhotodiodeSite& photodiode) {
  const double level = std::cos(photodiode.pitch_rad);
  return {level * std::cos(photodiode.yaw_rad), level * std::sin(photodiode.yaw_rad),
          std::sin(photodiode.pitch_rad)};
}

inline Eigen::Vector3d stands_at_m(const PhotodiodeSite& photodiode) {
  return {photodiode.position_m[0].mean, photodiode.position_m[1].mean,
          photodiode.position_m[2].mean};
}

/// Light of a vehicle whose lamps fall off by so many nat per rad^2 of azimuth.
inline double rim_light(const Vehicle& vehicle, double fall_off, const RoadSite& road,
                        const PhotodiodeSite& photodiode, double rim_off_rad, const RimWorld& world,
                        double t_s) {
  const Lamps lamps = lamps_at(vehicle, road, t_s);
  const Eigen::Vector3d axis = looks_along(photodiode);
  double sum = 0.0;
  for (const Eigen::Vector3d& lamp_m : {lamps.left_m, lamps.right_m}) {
    const Eigen::Vector3d apart_m =
        (world.one_lamp ? lamps.middle_m : lamp_m) - stands_at_m(photodiode);
    if (apart_m.x() <= 0.0) continue;
    const double azimuth_rad = std::atan2(apart_m.y(), apart_m.x());
    sum += std::exp(-fall_off * azimuth_rad * azimuth_rad) *
           std::max(0.0, apart_m.normalized().dot(axis)) / apart_m.squaredNorm() *
           seen_share(apart_m, axis, photodiode.half_field_of_view_rad + rim_off_rad,
                      world.rim_width_rad);
  }
  return sum;
}

/// A photodiode for each rim, 2 m apart along the road from a mast of 4 m on, about an axis 10
/// degrees to the lane's side.
inline Site rim_site(const RimWorld& world) {
  Site site = mast_site(4.0);
  site.photodiodes.resize(world.rim_off_rad.size());
  for (std::size_t k = 0; k < world.rim_off_rad.size(); ++k) {
    PhotodiodeSite& photodiode = site.photodiodes[k];
    photodiode.position_m = site.camera->position_m;
    photodiode.position_m[0].mean += 2.0 * static_cast<double>(k);
    photodiode.yaw_rad = radians_from_degrees(-10.0);
    photodiode.pitch_rad = radians_from_degrees(-6.0);
    photodiode.half_field_of_view_rad = world.half_view_rad;
    photodiode.time_offset_s = {0.0, world.offset_std_s};
  }
  return site;
}

/// Vehicles of 8 to 33 m/s that the camera sees from 60 to 10 m; lamps whose light falls off
/// sideways by more or less; 40 dB at 60 m.
inline TimedPasses timed_passes(int count, const RimWorld& world, std::uint64_t seed) {
  Random random(seed);
  TimedPasses scene;
  scene.site = rim_site(world);
  scene.traces.resize(static_cast<std::size_t>(count));
  for (std::vector<PowerTrace>& traces : scene.traces) {
    Vehicle vehicle;
    vehicle.speed_mps = random.uniform(8.0, 33.0);
    vehicle.acceleration_mps2 = random.normal(0.0, 0.7);
    vehicle.lateral_m = random.normal(-4.0, 0.3);
    vehicle.height_m = random.normal(0.65, 0.1);
    vehicle.separation_m = random.normal(1.2, 0.15);
    const View view{.to_s = 50.0 / vehicle.speed_mps};
    vehicle.changes.push_back({view.to_s, world.unseen_mps2 * random.normal()});
    const double fall_off = random.uniform(0.5, 3.0);
    for (std::size_t k = 0; k < world.rim_off_rad.size(); ++k) {
      const auto light = [&](double t_s) {
        return rim_light(vehicle, fall_off, scene.site.road, scene.site.photodiodes[k],
                         world.rim_off_rad[k], world, t_s);
      };
      PowerTrace& trace = traces.emplace_back();
      trace.photodiode = static_cast<int>(k);
      trace.sample_period_s = 1.0 / world.rate_hz;
      trace.noise_sigma_w = 0.01 * light(0.0);
      trace.ambient_w = 0.5 * light(0.0);
      const double past_s = 66.0 / vehicle.speed_mps + 1.5;
      for (double even_s = 0.0; even_s < past_s && vehicle.along_at_m(even_s) > -6.0;
           even_s += trace.sample_period_s) {
        const double t_s =
            even_s + world.jitter * trace.sample_period_s * random.uniform(-0.5, 0.5);
        trace.time_s.push_back(t_s - world.time_offset_s);
        trace.power_w.push_back(static_cast<float>(light(t_s) + trace.ambient_w +
                                                   trace.noise_sigma_w * random.normal()));
      }
    }
    std::vector<std::string> warnings;
    auto fitted = fit_trajectories(track_of(vehicle, scene.site, view, random),
                                   Camera(*scene.site.camera), scene.site, warnings);
    if (!std::holds_alternative<std::vector<Trajectory>>(fitted)) continue;
    scene.passes.push_back({std::move(std::get<std::vector<Trajectory>>(fitted).front()), traces});
  }
  return scene;
}

}  // namespace vildar::simulated
