#pragma once

#include "estimate/geometry_fit.h"

namespace vildar {

/// How far from its own middle line one who keeps to a lane goes, standard deviation, and over what
/// time he does so alike: exp(-(dt / time)^2 / 2). Of lane keeping the part that passes within
/// seconds, some decimetre.
inline constexpr double kWeave_m = 0.1, kWeavesAlike_s = 1.5;

/// Beside a bend whose radius tells the scale a vehicle's way to and fro within its lane looks like
/// another radius: its curves, by HeadingSwings, become unknowns of the fit, in place of the own
/// vehicle's. Nothing where the road is straight.
void let_weave(GeometryProblem& problem);

}  // namespace vildar
