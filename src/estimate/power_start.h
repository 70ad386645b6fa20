#pragma once

#include "estimate/power_problem.h"

namespace vildar {

/// Parameters near enough to the optimum for Gauss-Newton: block means of the samples, inverted and
/// fitted by a weighted line, then improved on the blocks. Tries what is not known at all over a
/// few plausible values, and both sides of a peak. Refuses (outside_model) where no block lies in
/// the law's domain: brighter than the law is anywhere at this d.
std::variant<PowerVector, PowerRefusal> power_start(const PowerSamples& samples,
                                                    const PowerKnowledge& known,
                                                    const PowerSetting& setting);

/// The line through the path lengths that every single sample implies, weighted: right where the
/// light changes much within a block, poor where the noise is great. Nothing where K, d, gamma or
/// r_c are not known, or too few samples lie in the law's domain.
std::optional<PowerVector> power_start_by_samples(const PowerSamples& samples,
                                                  const PowerKnowledge& known,
                                                  const PowerSetting& setting);

}  // namespace vildar
