#pragma once

#include <vector>

#include "types/power.h"

namespace vildar {

/// Median of `values`, which are reordered; they must not be empty.
double median_of(std::vector<double>& values);

/// Value below which the given fraction of `values` lies; reorders them; they must not be empty.
double quantile_of(std::vector<double>& values, double fraction);

/// Sets sample_period_s, the noise's and the rounding's sigma, and the ambient with its sigma, from
/// the samples. A trace without any stays as it is.
void set_levels(PowerTrace& trace);

/// Sets the ambient with its sigma from the samples, of which there must be some, and what is said
/// of their noise and rounding.
void set_ambient(PowerTrace& trace);

}  // namespace vildar
