#pragma once

#include <span>
#include <vector>

#include "sink/run_summary.h"
#include "types/power.h"
#include "types/result.h"
#include "types/site.h"

namespace vildar {

/// Every pass in the trace that shows most of them: a dim or dead photodiode shows fewer than its
/// neighbours. What a lack of samples parts, as where a photodiode clips, counts as one. Photodiode
/// clock.
std::vector<PowerPass> passes_of(std::span<const PowerTrace> traces);

/// Each of them measured by light alone, numbered from 1.
std::vector<VehicleResult> measure_passes(const Site& site, std::span<const PowerTrace> traces);

struct SeenClip {
  double end_s = 0.0;      ///< time of its last frame
  bool truncated = false;  ///< it ends before the recording did
};

/// Counts and warns of passes at which no vehicle of the camera's was near: within the clip one out
/// of its view, or one that it missed. Those after a clip that was cut short are measured by their
/// light alone, and added to `vehicles`.
void add_unseen_passes(const Site& site, std::span<const PowerTrace> traces, const SeenClip& clip,
                       std::vector<VehicleResult>& vehicles, RunSummary& summary);

}  // namespace vildar
