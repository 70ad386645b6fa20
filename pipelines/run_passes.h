#pragma once

#include <span>
#include <vector>

#include "sink/run_summary.h"
#include "types/power.h"
#include "types/result.h"
#include "types/site.h"

namespace vildar {

/// Every pass in the trace that shows most of them: a dim or dead photodiode shows fewer than its
/// neighbours. Photodiode clock.
std::vector<PowerPass> passes_of(std::span<const PowerTrace> traces);

/// Each of them measured by light alone, numbered from 1.
std::vector<VehicleResult> measure_passes(const Site& site, std::span<const PowerTrace> traces);

/// Counts and warns of passes, between clip times 0 and `clip_end_s`, at which no vehicle of the
/// camera's was near: one out of its view, or one that it missed.
void note_unseen_passes(const Site& site, std::span<const PowerTrace> traces,
                        std::span<const VehicleResult> seen, double clip_end_s,
                        RunSummary& summary);

}  // namespace vildar
