#pragma once

#include <string>

#include "evaluate/folders.h"

namespace vildar {

// Truth and runs of a few frames, written by hand, with answers that can be worked out on paper.

inline constexpr double kExact = 1e-12;

/// A pair of lamps `separation_px` apart around (u, v).
inline LampPixels pair_at(double u_px, double v_px, double separation_px = 40.0) {
  return {Eigen::Vector2d(u_px - 0.5 * separation_px, v_px),
          Eigen::Vector2d(u_px + 0.5 * separation_px, v_px)};
}

/// In frames first..last at 10 Hz, still in the image.
inline TruthVehicle truth_at(std::string id, double u_px, int first, int last,
                             double speed_mps = 20.0) {
  TruthVehicle vehicle;
  vehicle.id = std::move(id);
  vehicle.direction = "oncoming";
  vehicle.speed_mps = speed_mps;
  vehicle.t_ref_s = 0.1 * first;
  for (int frame = first; frame <= last; ++frame) {
    TruthSighting sighting;
    sighting.frame = frame;
    sighting.t_s = 0.1 * frame;
    sighting.lamps = pair_at(u_px, 500.0);
    sighting.speed_mps = speed_mps;
    vehicle.sightings.push_back(sighting);
  }
  return vehicle;
}

inline RunVehicle run_at(std::string id, double u_px, int first, int last) {
  RunVehicle vehicle;
  vehicle.track_id = std::move(id);
  vehicle.direction = "oncoming";
  vehicle.outcome.withheld = "too_short";
  vehicle.t_first_s = 0.1 * first;
  vehicle.t_last_s = 0.1 * last;
  for (int frame = first; frame <= last; ++frame)
    vehicle.sightings.push_back({frame, pair_at(u_px, 500.0), {}, {}});
  return vehicle;
}

inline RunVehicle measured(RunVehicle vehicle, double t_ref_s, double speed_mps) {
  vehicle.outcome = {StatedSpeed{t_ref_s, speed_mps, 0.5, speed_mps - 1.0, speed_mps + 1.0}, ""};
  return vehicle;
}

}  // namespace vildar
