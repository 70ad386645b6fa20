#pragma once

#include "estimate/power_method.h"

namespace vildar {

/// Maximum likelihood on the full power law, every prior of `known` in it and an acceleration of
/// 0 +- 1.5 m/s^2: the row `ml_photodiode`. Samples are averaged over 10 ms; one percent of the
/// light counts as noise, for what pitching does that the law does not know. The error of the
/// background is carried through, and what lamps unlike the law may do. The 95 % interval is
/// log-normal. Misses: those of the estimator, and bad_fit where the light does not follow the law
/// within 0.05 nat or only with its priors strained.
Outcome<PowerSpeed> ml_speed(const PowerSeries& series, const PowerCase& known);

}  // namespace vildar
