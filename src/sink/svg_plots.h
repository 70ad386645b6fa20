#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "types/result.h"

namespace vildar {

/// The value that the program stands by, drawn over a series.
struct PlotMark {
  double t_s = 0.0;
  double value = 0.0;
  std::optional<double> low, high;  ///< ends of the 95 % interval
};

/// One quantity over time.
struct TimePlot {
  std::string title;  ///< with the unit, stands over the vertical axis
  std::span<const double> t_s;
  std::vector<double> values;
  std::optional<PlotMark> mark;
  bool from_zero = false;  ///< the vertical axis includes zero
};

/// An SVG drawing; empty where fewer than two points are finite or the lengths differ.
std::string svg_time_plot(const TimePlot& plot);

/// Speeds of all measured vehicles: a vehicle counts in each bar by the probability that its speed
/// lies there; below, every vehicle with its 95 % interval (up to 40 of them). Empty where nothing
/// was measured.
std::string svg_speed_histogram(std::span<const VehicleResult> vehicles,
                                std::optional<double> speed_limit_mps);

/// A dot with its 95 % interval on a scale that several rows share; km/h.
std::string svg_interval(const SpeedEstimate& speed, double low_kmh, double high_kmh,
                         bool reported);

}  // namespace vildar
