#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/atomic_file.h"
#include "sink/run_summary.h"
#include "types/result.h"

namespace vildar {

/// What was seen of a vehicle over time, for the plots of the report; thinned by the caller to
/// about 200 points. A series is either empty or as long as `t_s`; non-finite values leave a gap.
struct TrackPlot {
  int track_id = 0;
  std::vector<double> t_s, range_m, speed_mps, azimuth_rad, intensity;
};

/// One self-contained page: no script, no external file, fit for print. Everything that comes from
/// inputs is escaped.
std::string report_text(const RunSummary& summary, std::span<const VehicleResult> vehicles,
                        std::span<const TrackPlot> plots);

/// report.html, finished and not yet committed; throws OutputError.
[[nodiscard]] AtomicFile write_report(const std::filesystem::path& path, const RunSummary& summary,
                                      std::span<const VehicleResult> vehicles,
                                      std::span<const TrackPlot> plots);

}  // namespace vildar
