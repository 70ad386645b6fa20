#pragma once

#include "core/atomic_file.h"
#include "pipelines/run_clip.h"

namespace vildar {

/// Second reading of the clip: annotated.mp4 with every vehicle's outline, number, speed or reason,
/// and trail, not yet committed.
[[nodiscard]] AtomicFile annotate_clip(const RunOptions& options,
                                       const ClipMeasurement& measurement);

}  // namespace vildar
