#include "pipelines/run_passes.h"

#include <algorithm>

#include "condition/condition.h"
#include "core/text.h"
#include "estimate/vehicle.h"
#include "pipelines/interrupt.h"

namespace vildar {

std::vector<PowerPass> passes_of(std::span<const PowerTrace> traces) {
  std::vector<PowerPass> most;
  for (const PowerTrace& trace : traces) {
    std::vector<PowerPass> passes = find_passes(trace);
    if (passes.size() > most.size()) most = std::move(passes);
  }
  return most;
}

std::vector<VehicleResult> measure_passes(const Site& site, std::span<const PowerTrace> traces) {
  std::vector<VehicleResult> vehicles;
  for (const PowerPass& pass : passes_of(traces)) {
    throw_if_interrupted();
    vehicles.push_back(estimate_pass(pass, static_cast<int>(vehicles.size()) + 1, site, traces));
  }
  return vehicles;
}

void note_unseen_passes(const Site& site, std::span<const PowerTrace> traces,
                        std::span<const VehicleResult> seen, double clip_end_s,
                        RunSummary& summary) {
  // Lamps shine on a photodiode before the camera makes them out, and until they have driven past
  // it, out of the camera's view.
  constexpr double kBefore_s = 1.0, kAfter_s = 5.0;
  if (traces.empty()) return;
  std::int64_t unseen = 0;
  for (const PowerPass& pass : passes_of(traces)) {
    const PhotodiodeSite& photodiode = site.photodiodes[static_cast<std::size_t>(pass.photodiode)];
    const double peak_s = pass.peak_s + photodiode.time_offset_s.mean;
    if (peak_s < 0.0 || peak_s > clip_end_s) continue;
    if (std::any_of(seen.begin(), seen.end(), [&](const VehicleResult& vehicle) {
          return peak_s > vehicle.t_first_s - kBefore_s && peak_s < vehicle.t_last_s + kAfter_s;
        }))
      continue;
    ++unseen;
    summary.warnings.push_back(photodiode.id + ": light as of a passing vehicle at " +
                               fixed_text(peak_s, 2) +
                               " s, but the camera saw none near that time; it has no speed, check "
                               "the camera's view");
  }
  summary.counts["passes_unseen_by_camera"] = unseen;
}

}  // namespace vildar
