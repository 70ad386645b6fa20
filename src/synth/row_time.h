#pragma once

#include <optional>

#include "optics/camera.h"

namespace vildar {

/// Clip time at which row `v_px` (fractions allowed) of a frame is half exposed.
inline double time_of_row_s(const CameraSite& site, double frame_time_s, double v_px) {
  return frame_time_s + ((v_px + 0.5) / site.height_px - 0.5) * site.rolling_shutter_s;
}

/// A moving point on a rolling-shutter picture: the pixel where it lies when its own row is half
/// exposed, and that time.
struct RowSighting {
  Eigen::Vector2d pixel_px = Eigen::Vector2d::Zero();
  double time_s = 0.0;
};

/// `position_m(time_s)` gives the road-frame place. Nothing where it cannot be projected, or where
/// the steps do not settle: within a metre or two of the camera it outruns the rows.
template <class Position>
std::optional<RowSighting> sighting_at_row_time(const Camera& camera, const CameraSite& site,
                                                double frame_time_s, const Position& position_m) {
  // A lamp crosses far less than one row in the time of a row, so each step gains decimals.
  constexpr int kMostSteps = 100;
  constexpr double kTolerance_px = 1e-9;
  RowSighting sighting;
  sighting.time_s = frame_time_s;
  for (int step = 0; step < kMostSteps; ++step) {
    const auto pixel = camera.project(position_m(sighting.time_s));
    if (!pixel) return std::nullopt;
    const bool settled = step > 0 && (*pixel - sighting.pixel_px).norm() < kTolerance_px;
    sighting.pixel_px = *pixel;
    if (settled || site.rolling_shutter_s == 0.0) return sighting;
    sighting.time_s = time_of_row_s(site, frame_time_s, pixel->y());
  }
  return std::nullopt;
}

inline bool inside_image(const CameraSite& site, const Eigen::Vector2d& pixel_px) {
  return pixel_px.x() >= -0.5 && pixel_px.x() <= site.width_px - 0.5 && pixel_px.y() >= -0.5 &&
         pixel_px.y() <= site.height_px - 0.5;
}

}  // namespace vildar
