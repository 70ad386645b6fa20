#pragma once

#include <cmath>
#include <vector>

#include "calib/photodiode/learn.h"
#include "estimate/simulated_beam.h"

namespace vildar::simulated {

/// Passes that a camera and two photodiodes saw, and the site file as its owner wrote it. Passes
/// point into `traces`.
struct LitPasses {
  Site site;
  std::vector<std::vector<PowerTrace>> traces;
  std::vector<LitPass> passes;
};

/// From a mast of 4 m, the second photodiode 2 m down the road; beams with 0.1 nat of ripple that
/// no estimator knows, 40 dB, 0.2 px. The file has offset 0 +- 0.03 s and gain ratio 1 +- 0.1.
inline LitPasses lit_passes(int count, double time_offset_s, double gain_ratio,
                            std::uint64_t seed) {
  Random random(seed);
  LitPasses scene;
  scene.site = mast_site(4.0);
  scene.site.photodiodes.resize(2);
  for (PhotodiodeSite& photodiode : scene.site.photodiodes) {
    photodiode.position_m = scene.site.camera->position_m;
    photodiode.time_offset_s.std = 0.03;
  }
  scene.site.photodiodes[1].position_m[0].mean += 2.0;
  scene.site.photodiodes[1].gain_ratio.std = 0.1;
  // Half of the variance of the site's lengths is what its vehicles have in common.
  const double common_height_m = random.normal(0.65, 0.1 * std::sqrt(0.5)),
               common_separation_m = random.normal(1.2, 0.15 * std::sqrt(0.5)),
               common_lateral_m = random.normal(-4.0, 0.3 * std::sqrt(0.5));
  scene.traces.resize(static_cast<std::size_t>(count));
  for (std::vector<PowerTrace>& traces : scene.traces) {
    Vehicle vehicle;
    vehicle.speed_mps = random.uniform(10.0, 30.0);
    vehicle.acceleration_mps2 = random.normal(0.0, 1.0);
    vehicle.lateral_m = random.normal(common_lateral_m, 0.3 * std::sqrt(0.5));
    vehicle.height_m = random.normal(common_height_m, 0.1 * std::sqrt(0.5));
    vehicle.separation_m = random.normal(common_separation_m, 0.15 * std::sqrt(0.5));
    const Beam beam = random_beam(0.1, random);
    for (int photodiode : {0, 1}) {
      Receiving receiving;
      receiving.gain = photodiode == 0 ? 1.0 : gain_ratio;
      receiving.time_offset_s = time_offset_s;
      traces.push_back(beam_trace(vehicle, scene.site, beam, photodiode, receiving, random));
    }
    const View view{.to_s = 50.0 / vehicle.speed_mps};
    std::vector<std::string> warnings;
    auto fitted = fit_trajectories(track_of(vehicle, scene.site, view, random),
                                   Camera(*scene.site.camera), scene.site, warnings);
    if (!std::holds_alternative<std::vector<Trajectory>>(fitted)) continue;
    LitPass& pass = scene.passes.emplace_back();
    pass.way = std::move(std::get<std::vector<Trajectory>>(fitted).front());
    for (const PowerTrace& trace : traces) pass.power.push_back({&trace, false});
  }
  return scene;
}

}  // namespace vildar::simulated
