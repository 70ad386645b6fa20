#pragma once

#include <array>
#include <cmath>

#include "delay_pass.h"
#include "estimate/delay_light.h"

namespace vildar::simulated {

/// The light of one vehicle on two photodiodes.
struct Pair {
  PowerTrace near, far;

  Outcome<DelayFit> speed(const Site& site, double asked_from_s = -INFINITY,
                          double asked_to_s = INFINITY) const {
    const std::array<const PowerTrace*, 2> traces{&near, &far};
    return delay_speed(site, traces, 0.0, 8.0, asked_from_s, asked_to_s);
  }
};

inline Pair pair_of(const Vehicle& vehicle, const Site& site, Receiving receiving = {},
                    double far_gain = 1.0, double far_angular_gain = 0.0, const Beam& beam = {}) {
  Random random(7);
  Pair pair;
  pair.near = beam_trace(vehicle, site, beam, 0, receiving, random);
  receiving.gain = far_gain;
  receiving.angular_gain = far_angular_gain;
  pair.far = beam_trace(vehicle, site, beam, 1, receiving, random);
  return pair;
}

}  // namespace vildar::simulated
