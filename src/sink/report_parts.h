#pragma once

#include <optional>
#include <span>
#include <string>

#include "sink/report.h"

namespace vildar {

// Pieces of the report, each a run of HTML; empty where there is nothing to show.

/// Name of what was measured: the clip's file, else the photodiode's.
std::string report_title(const RunSummary& summary);
std::string report_head(const RunSummary& summary, std::span<const VehicleResult> vehicles);
std::string report_warnings(const RunSummary& summary);
std::string report_vehicles(std::span<const VehicleResult> vehicles);
std::string report_methods(std::span<const VehicleResult> vehicles);
/// Methods and plots of one vehicle; `plot` may be null.
std::string report_vehicle(const VehicleResult& vehicle, const TrackPlot* plot, bool open);
std::string report_making(const RunSummary& summary);

}  // namespace vildar
