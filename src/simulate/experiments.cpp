#include "simulate/experiments.h"

#include <array>

namespace vildar::simulate {

std::span<const Experiment> experiments() {
  static constexpr std::array<Experiment, 13> kAll{{
      {"straight-duration", "accuracy against incidence angle for several windows, and radar",
       straight_duration},
      {"straight-snr", "accuracy against incidence angle for several initial SNRs", straight_snr},
      {"straight-speed", "accuracy against window length for several speeds", straight_speed},
      {"straight-half-angle", "accuracy against incidence angle for several half-power angles",
       straight_half_angle},
      {"straight-channel", "accuracy for the simulated and the Lambertian channel",
       straight_channel},
      {"geometry", "incidence angle and range over time, straight road", geometry},
      {"curved-geometry", "incidence angle, range and offset over time, curved road",
       curved_geometry},
      {"curved-duration", "accuracy over time for several windows, and radar, curved road",
       curved_duration},
      {"curved-snr", "accuracy over time for several initial SNRs, curved road", curved_snr},
      {"path-loss", "path loss of both channels, and what a line of sight alone gives", path_loss},
      {"received-power", "received power over time, and where a speed can be had from it",
       received_power},
      {"bounds", "Cramer-Rao bounds of the speed for sets of unknowns", bounds},
      {"efficiency", "error over the bound, and coverage, of every estimator", efficiency},
  }};
  return kAll;
}

}  // namespace vildar::simulate
