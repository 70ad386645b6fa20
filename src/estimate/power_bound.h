#pragma once

#include <span>

#include "estimate/power_problem.h"

namespace vildar {

/// Cramer-Rao bound: the least covariance that an unbiased estimator can have, for samples at
/// `time_s` (relative to the time at which `truth` holds) with white noise of `sigma_w`, and with
/// what `known` says; priors add their information, which makes it the Bayesian bound at `truth`.
/// Refuses what is not observable, by name. Throws std::domain_error unless sigma > 0.
std::variant<PowerMatrix, PowerRefusal> power_bound(std::span<const double> time_s, double sigma_w,
                                                    const PowerVector& truth,
                                                    const PowerKnowledge& known,
                                                    const PowerSetting& setting);

/// The same with one sigma for each sample. Throws std::invalid_argument for spans of different
/// length.
std::variant<PowerMatrix, PowerRefusal> power_bound(std::span<const double> time_s,
                                                    std::span<const double> sigma_w,
                                                    const PowerVector& truth,
                                                    const PowerKnowledge& known,
                                                    const PowerSetting& setting);

}  // namespace vildar
