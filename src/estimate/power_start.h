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

}  // namespace vildar
