#pragma once

#include "estimate/trajectory.h"

namespace vildar {

/// How much of a trajectory's speed sigma is shape and how much scale, and what fixes the scale. On
/// a straight road moving all lengths together leaves every bearing as it is, so the scale's
/// information is that of the metric priors alone; what else there is (light with a known gain, a
/// curve that begins at a known place) is listed as `other`.
SpeedBudget speed_budget(const Trajectory& trajectory, double time_s);

/// Chi-square of the bearings per degree of freedom, by the centroids' own sigmas.
double bearing_chi2_per_dof(const Trajectory& trajectory);

}  // namespace vildar
