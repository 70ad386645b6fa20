#pragma once

#include <functional>
#include <optional>

#include "optics/camera.h"
#include "scene.h"
#include "track/vehicle.h"

namespace vildar::scene {

/// A mast, and lamps 70 m before it that come nearer by half a metre a frame of 0.04 s.
struct OneCar {
  Site site = site_of(5.0, -4.0, 1400.0, 1920, 1080);
  RoadView view{site};
  Camera camera{*site.camera};

  static CameraTime time_at(std::int64_t frame) {
    return time_from_seconds<CameraTime>(0.04 * static_cast<double>(frame));
  }

  /// A lamp at y_m, followed from frame `first` to `last`, `ahead_m` nearer than the others.
  Lamp lamp(std::int64_t first, std::int64_t last, double y_m, double ahead_m = 0.0,
            double flux = 100.0, LampKind kind = LampKind::headlamp) const {
    return lamp(
        first, last, [y_m](std::int64_t) { return y_m; }, ahead_m, flux, kind);
  }

  /// One whose y depends on the frame.
  Lamp lamp(std::int64_t first, std::int64_t last, const std::function<double(std::int64_t)>& y_m,
            double ahead_m = 0.0, double flux = 100.0, LampKind kind = LampKind::headlamp) const {
    std::optional<Lamp> made;
    for (std::int64_t frame = first; frame <= last; ++frame) {
      Blob blob;
      blob.centre_px =
          *camera.project({70.0 - ahead_m - 0.5 * static_cast<double>(frame), y_m(frame), 0.68});
      blob.flux = flux;
      blob.kind = kind;
      const Spot spot{&blob, *view.spot_from_pixel(blob.centre_px), 0.5, blob.centre_px,
                      blob.centre_sigma_px};
      if (!made) {
        made.emplace(spot, view.place(spot.at_px), frame, time_at(frame), view);
      } else {
        made->predict(0.04, view);
        made->update(spot, frame, time_at(frame));
      }
    }
    return *made;
  }
};

inline Vehicle vehicle_of(Lamp& left, Lamp& right, int both_seen = 0) {
  Vehicle vehicle;
  vehicle.left = &left;
  vehicle.right = &right;
  vehicle.both_seen = both_seen;
  return vehicle;
}

}  // namespace vildar::scene
