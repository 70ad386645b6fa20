#pragma once

#include <vector>

#include "pipelines/run_pipeline.h"
#include "types/power.h"
#include "types/site.h"

namespace vildar {

/// The photodiode traces that `options` names, ready for use; what was left out is counted and
/// warned of in `summary`. A photodiode that is dead, with one value throughout or none, is left
/// out and named. A broken trace beside a clip does not stop the run: it is named, and the camera
/// goes on alone. Throws InputError where there is no clip and no trace to be used.
std::vector<PowerTrace> read_traces(const RunOptions& options, const Site& site,
                                    RunSummary& summary);

/// Warns, and counts the input as damaged, where a trace and the clip, from 0 to `clip_end_s`, have
/// no time in common even at the edge of what the site file allows for their offset.
void note_overlap(const RunOptions& options, const Site& site,
                  const std::vector<PowerTrace>& traces, double clip_end_s, RunSummary& summary);

}  // namespace vildar
