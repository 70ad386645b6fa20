#pragma once

#include <vector>

#include "types/power.h"

namespace vildar {

/// Median of `values`, which are reordered; they must not be empty.
double median_of(std::vector<double>& values);

/// Value below which the given fraction of `values` lies; reorders them; they must not be empty.
double quantile_of(std::vector<double>& values, double fraction);

/// Sets sample_period_s, noise_sigma_w and ambient_w from the samples.
void set_levels(PowerTrace& trace);

}  // namespace vildar
