#pragma once

#include <functional>
#include <span>
#include <string_view>

#include "simulate/figure.h"
#include "simulate/options.h"

namespace vildar::simulate {

struct Experiment {
  std::string_view name;
  std::string_view summary;
  Report (*run)(const Options& options);
};

/// The paper's experiments by name, then the bounds and the efficiency of the estimators.
std::span<const Experiment> experiments();

// One family per file.
Report straight_duration(const Options& options);
Report straight_snr(const Options& options);
Report straight_speed(const Options& options);
Report straight_half_angle(const Options& options);
Report straight_channel(const Options& options);
Report geometry(const Options& options);
Report curved_geometry(const Options& options);
Report curved_duration(const Options& options);
Report curved_snr(const Options& options);
Report path_loss(const Options& options);
Report received_power(const Options& options);
Report bounds(const Options& options);
Report efficiency(const Options& options);

}  // namespace vildar::simulate
