#pragma once

#include "pipelines/run_clip.h"

namespace vildar {

/// Second reading of the clip: writes annotated.mp4 with every vehicle's outline, number, speed or
/// reason, and trail.
void annotate_clip(const RunOptions& options, const ClipMeasurement& measurement);

}  // namespace vildar
