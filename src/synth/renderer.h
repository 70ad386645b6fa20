#pragma once

#include "optics/camera.h"
#include "synth/light_plane.h"
#include "synth/sensor.h"
#include "types/frame.h"

namespace vildar {

/// Pictures of a scenario as its camera takes them. Not thread-safe: one Renderer per thread.
class Renderer {
 public:
  /// Throws std::invalid_argument where the scenario's site has no camera or no exposure time.
  explicit Renderer(const Scenario& scenario);

  /// The picture whose middle row is half exposed at clip time `time_s`; 8-bit limited range,
  /// 4:2:0. Its index, which also seeds the noise, is the nearest frame number of the scenario's
  /// frame rate.
  Frame image(double time_s);

  /// The lamps of that picture as they fall on the sensor, in no order that means anything.
  std::vector<LampImage> lamps(double time_s) const;

 private:
  Scenario scenario_;
  CameraSite site_;
  Camera camera_;
  double exposure_s_;
  Psf psf_;
  LightPlane light_;
  Sensor sensor_;
  std::vector<float> background_e_;
};

}  // namespace vildar
