#pragma once

#include <span>
#include <vector>

#include "types/site.h"

namespace vildar {

/// Seconds of clip time; from_s < to_s.
struct TimeSpan {
  double from_s = 0.0, to_s = 0.0;
};

/// Standard deviation of the noise from sample to sample of evenly stamped values, by their fourth
/// differences: what turns a vehicle, or speeds it up, is nothing in these. 0 of less than five.
double trace_noise(std::span<const double> values);

/// The trace with the speeds while another vehicle is watched, and half a second about that, as the
/// polynomial of least degree that leaves no more than their noise, where one of up to 10 does: the
/// way that noise adds up to passes for one driven, and is a base line for the other's distance.
std::vector<EgoSample> without_speed_noise(std::vector<EgoSample> trace, const TimeSpan& watched);

}  // namespace vildar
