#pragma once

#include <functional>

#include "estimate/power_method.h"

namespace vildar {

/// Variance that lamps unlike the law (PassPosterior::ripple_nat) add to what `estimate` makes of a
/// series: the pull of each shape (BeamShapes) times its standard deviation, in quadrature.
/// Of lamps of which nothing is told, K being fitted to their light, the smooth shapes are those
/// that headlamps differ by, whatever the light itself says: with the angle that they are seen at
/// going with the distance, they pass for speed. Infinite where `estimate` gives nothing.
double beam_variance(const PowerSeries& series, const PowerCase& known, const PassMotion& motion,
                     double ripple_nat, const std::function<double(const PowerSeries&)>& estimate);

}  // namespace vildar
