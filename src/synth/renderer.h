#pragma once

#include <optional>
#include <vector>

#include "optics/camera.h"
#include "synth/background.h"
#include "synth/ego.h"
#include "synth/light_plane.h"
#include "synth/road_light.h"
#include "synth/row_time.h"
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
  struct Planes;
  std::vector<QuadImage> signs(double time_s) const;
  /// A scene point at its own time as the camera's pose sees it in a frame.
  template <class Position>
  std::optional<RowSighting> sighting(double time_s, const Position& position_m) const;
  void prepare_ground(double time_s);
  /// Mean electrons of a row, black level included.
  void gather_row(int v, const Eigen::Vector2d& shift_px, float* light_e);
  void expose_luminance(Planes& planes, double time_s, std::int64_t frame);
  void expose_mosaic(Planes& planes, double time_s, std::int64_t frame);

  Scenario scenario_;
  CameraSite site_;
  Camera camera_;
  CameraShake shake_;
  double exposure_s_;
  double electrons_per_cd_;  ///< of a pixel, per cd/m^2
  Psf psf_;
  LightPlane light_;
  Sensor sensor_;
  GroundMap ground_;
  bool ground_turns_;  ///< the road moves in the image
  Background background_;
  RoadLight road_light_;
  std::vector<float> road_row_;
};

}  // namespace vildar
