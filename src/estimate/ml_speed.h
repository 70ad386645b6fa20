#pragma once

#include "estimate/power_method.h"

namespace vildar {

/// The mean of ln V over the posterior of the full power law (pass_posterior), every prior of
/// `known`, lamps unlike the law and the background in it: the row `ml_photodiode`. The 95 %
/// interval is log-normal. Misses: outside_model where no motion explains the light, or lamps
/// unlike the law do; bad_fit where it is explained poorly or only with the priors strained;
/// too_uncertain.
Outcome<PowerSpeed> ml_speed(const PowerSeries& series, const PowerCase& known);

}  // namespace vildar
