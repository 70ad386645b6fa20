#pragma once

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "estimate/vehicle.h"
#include "simulated_power.h"

namespace vildar::simulated {

/// One photodiode on a mast whose gain and place are known, and light as its channel says.
inline constexpr double kGain_db = -45.0;

inline Site diode_site() {
  Site site = mast_site(4.0);
  site.road.lanes[0].lateral_m.std = 0.05;
  site.lamps.height_m->std = 0.02;
  site.photodiodes.resize(1);
  site.photodiodes[0].id = "pd0";
  site.photodiodes[0].position_m = {Uncertain{0.0, 0.0}, Uncertain{0.0, 0.0}, Uncertain{4.0, 0.0}};
  site.channel = ChannelSite{};
  site.channel->gain_db = Uncertain{kGain_db, 0.0};
  site.channel->path_loss_exponent = Uncertain{1.8, 0.0};
  return site;
}

inline Diode matching_diode() {
  Diode diode;
  diode.gain_w = std::pow(10.0, 0.1 * kGain_db);
  diode.path_loss_exponent = 1.8;
  diode.ambient_w = 1e-8;
  diode.noise_w = 1e-12;
  return diode;
}

inline const MethodResult& method_of(const VehicleResult& result, Method method) {
  for (const MethodResult& row : result.methods)
    if (row.method == method) return row;
  throw std::out_of_range("method missing from the result");
}

inline double speed_of(const MethodResult& row) {
  if (const Miss* miss = std::get_if<Miss>(&row.speed)) {
    ADD_FAILURE() << name_of(*miss);
    return 0.0;
  }
  return std::get<SpeedEstimate>(row.speed).speed_mps;
}

}  // namespace vildar::simulated
