#pragma once

#include <vector>

#include "types/power.h"

namespace vildar {

/// Median of `values`, which are reordered; they must not be empty.
double median_of(std::vector<double>& values);

/// Value below which the given fraction of `values` lies; reorders them; they must not be empty.
double quantile_of(std::vector<double>& values, double fraction);

/// Sets sample_period_s and the noise's and the rounding's sigma from the samples. A trace without
/// any stays as it is.
void set_noise(PowerTrace& trace);

/// Sets the ambient with its sigma from the samples and what is said of their noise and rounding. A
/// trace without any stays as it is.
void set_ambient(PowerTrace& trace);

/// Level of the darkest tenth.
float dark_level_w(const std::vector<float>& power_w);

}  // namespace vildar
