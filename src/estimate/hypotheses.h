#pragma once

#include <string>
#include <vector>

#include "estimate/metric_priors.h"
#include "estimate/trajectory.h"

namespace vildar {

/// Fits a vehicle as each thing that it may be: every class of lamps, in every lane that its path
/// comes near, and in no lane. `seen` is a fit of its bearings with any metric priors but a lane's;
/// it gives observations, sigmas and the start. Weighed and sorted as by weigh().
/// Misses: not_on_road, not_converged, unobservable.
Outcome<std::vector<Trajectory>> fit_hypotheses(const Trajectory& seen,
                                                const std::vector<LampReading>& readings,
                                                const Site& site, Direction direction);

/// Gives each trajectory its posterior probability, by Laplace's approximation of its evidence and
/// its log_prior; the likeliest comes first, and those of no consequence are dropped, as are, of
/// several, those whose evidence is no number. All share their observations and the kinds of their
/// priors.
void weigh(std::vector<Trajectory>& trajectories);

}  // namespace vildar
