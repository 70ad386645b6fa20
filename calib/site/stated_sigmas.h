#pragma once

#include <vector>

#include "calib/site/spreads.h"

namespace vildar {

/// Standard deviations to state in a site file (m, rad, relative), one per population, that keep
/// the intervals of single vehicles true although a site file can only state independent
/// quantities. A turn and the focal length get their mean's sigma and the spread. A length's spread
/// is widened so that any set of height, separation and lane that an estimate may combine claims no
/// more on the scale than it knows, the error that all means have in common included.
std::vector<double> stated_stds(const std::vector<Population>& populations, const Learned& learned);

/// Relative sigma of ln scale that the means of headlamps' height, separation and the first lane
/// (those that there are) and of the focal length leave to all vehicles together.
double common_scale_std(const std::vector<Population>& populations,
                        const Eigen::MatrixXd& covariance);

}  // namespace vildar
