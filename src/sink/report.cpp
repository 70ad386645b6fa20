#include "sink/report.h"

#include "core/atomic_file.h"

namespace vildar {

std::string report_text(const RunSummary& summary, std::span<const VehicleResult> vehicles,
                        std::span<const TrackPlot> plots) {
  (void)summary;
  return "<!DOCTYPE html><html lang=\"en\"><head><meta "
         "charset=\"utf-8\"><title>vildar</title></head><body><p>" +
         std::to_string(vehicles.size()) + " vehicles, " + std::to_string(plots.size()) +
         " plots</p></body></html>\n";
}

void write_report(const std::filesystem::path& path, const RunSummary& summary,
                  std::span<const VehicleResult> vehicles, std::span<const TrackPlot> plots) {
  write_file_atomically(path, report_text(summary, vehicles, plots));
}

}  // namespace vildar
