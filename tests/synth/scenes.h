#pragma once

#include <string>

#include "synth/photodiode_trace.h"
#include "synth/scenario.h"

namespace vildar {

/// A small scene for tests: a 320x180 camera and a photodiode on a 5 m mast, one oncoming lane, and
/// no vehicle yet.
inline Scenario small_scene() {
  Scenario scenario;
  scenario.file = "small.yaml";
  scenario.duration_s = 0.4;
  scenario.frame_rate_hz = 25.0;
  scenario.seed = 7;
  CameraSite camera;
  camera.width_px = 320;
  camera.height_px = 180;
  camera.focal_px = {300.0, 300.0};
  camera.principal_px = {159.5, 89.5};
  camera.position_m[2].mean = 5.0;
  camera.yaw_rad.mean = -0.05;
  camera.pitch_rad.mean = -0.12;
  camera.exposure_s = 0.001;
  scenario.site.camera = camera;
  PhotodiodeSite photodiode;
  photodiode.id = "pd0";
  photodiode.position_m[2].mean = 5.0;
  scenario.site.photodiodes.push_back(photodiode);
  ChannelSite channel;
  channel.gain_db = Uncertain{-42.4, 0.0};
  channel.path_loss_exponent = Uncertain{1.8, 0.0};
  scenario.site.channel = channel;
  scenario.site.road.lanes = {{"near", {-3.0, 0.0}, 3.5, Direction::oncoming},
                              {"far", {-6.5, 0.0}, 3.5, Direction::receding}};
  return scenario;
}

inline VehicleScene car_at(double along_m, double speed_mps) {
  VehicleScene vehicle;
  vehicle.id = "car";
  vehicle.along_at_zero_m = along_m;
  vehicle.speed_mps = speed_mps;
  return vehicle;
}

/// The whole photodiode.csv.
inline std::string trace_text(const Scenario& scenario) {
  std::string text = trace_csv_header(scenario);
  TraceRenderer renderer(scenario);
  while (const TraceRenderer::Sample* sample = renderer.next())
    text += trace_csv_line(scenario, *sample);
  return text;
}

}  // namespace vildar
