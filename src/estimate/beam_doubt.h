#pragma once

#include <functional>
#include <optional>

#include "estimate/power_method.h"

namespace vildar {

/// How far the vehicle's lamps may be unlike the law: standard deviation, nat, of the first cosine
/// of the azimuth off its path, that of the k-th being a k-th of it. Ways from 0.01 to 0.5 nat are
/// weighed by how well the light follows the law so bent, with all that `known` leaves open, the
/// background and a constant acceleration of 0 +- 1.5 m/s^2; the root mean square over them. Blocks
/// of 20 ms, one percent of each unmodelled. `start` is where the fits begin. Nothing where no
/// motion near it explains the light or there are fewer than five blocks.
std::optional<double> beam_ripple_nat(const PowerSeries& series, const PowerCase& known,
                                      const PassMotion& start);

/// Variance that lamps so unlike the law add to what `estimate` makes of a series: the pull of each
/// cosine times its standard deviation, in quadrature. Infinite where `estimate` gives nothing.
double beam_variance(const PowerSeries& series, const PowerCase& known, const PassMotion& motion,
                     double ripple_nat, const std::function<double(const PowerSeries&)>& estimate);

}  // namespace vildar
