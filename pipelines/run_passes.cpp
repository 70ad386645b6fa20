#include "pipelines/run_passes.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "condition/condition.h"
#include "core/text.h"
#include "estimate/contradictions.h"
#include "estimate/vehicle.h"
#include "pipelines/interrupt.h"

namespace vildar {

namespace {

// How many passes a lack of samples, as of a clipped peak, parts from the one before.
std::size_t parted_by_gaps(const PowerTrace& trace, std::span<const PowerPass> passes) {
  constexpr double kGap_s = 0.05, kAtOnce_s = 0.1;
  std::size_t parted = 0;
  for (std::size_t i = 1; i < passes.size(); ++i) {
    const double ends_s = passes[i - 1].to_s, begins_s = passes[i].from_s;
    const auto first = std::ranges::lower_bound(trace.time_s, passes[i - 1].peak_s);
    const auto last = std::ranges::upper_bound(trace.time_s, passes[i].peak_s);
    parted += std::adjacent_find(first, last, [&](double one_s, double next_s) {
                return next_s - one_s > kGap_s && std::abs(one_s - ends_s) < kAtOnce_s &&
                       std::abs(next_s - begins_s) < kAtOnce_s;
              }) != last;
  }
  return parted;
}

}  // namespace

std::vector<PowerPass> passes_of(std::span<const PowerTrace> traces) {
  std::vector<PowerPass> most;
  std::size_t most_whole = 0, fewest_parted = 0;
  for (const PowerTrace& trace : traces) {
    std::vector<PowerPass> passes = find_passes(trace);
    const std::size_t parted = parted_by_gaps(trace, passes), whole = passes.size() - parted;
    if (whole < most_whole || (whole == most_whole && parted >= fewest_parted)) continue;
    most = std::move(passes);
    most_whole = whole;
    fewest_parted = parted;
  }
  return most;
}

std::vector<VehicleResult> measure_passes(const Site& site, std::span<const PowerTrace> traces) {
  std::vector<VehicleResult> vehicles;
  for (const PowerPass& pass : passes_of(traces)) {
    throw_if_interrupted();
    vehicles.push_back(estimate_pass(pass, static_cast<int>(vehicles.size()) + 1, site, traces));
  }
  check_law(vehicles);
  return vehicles;
}

namespace {

// Lamps shine on a photodiode before the camera makes them out, and until they have driven past
// it, out of the camera's view; a clip that ends at `end_s` leaves them on their way to it, as does
// a record that is cut off before they are past: `peak_s` is its end then.
bool lights(const VehicleResult& vehicle, double peak_s, bool cut_off,
            const PhotodiodeSite& photodiode, double end_s) {
  constexpr double kBefore_s = 1.0, kAfter_s = 5.0, kWayShare = 0.25;
  const bool in_view =
      peak_s > vehicle.t_first_s - kBefore_s && peak_s < vehicle.t_last_s + kAfter_s;
  // When one without a speed drives by is not known; one that brakes comes later than its speed
  // says.
  constexpr double kSlow_mps = 8.0;
  if (vehicle.withheld || vehicle.speed.speed_mps < kSlow_mps) return in_view;
  const bool within_clip = in_view && peak_s <= end_s;
  if (vehicle.direction != Direction::oncoming || !vehicle.range_ref_m) return within_clip;
  const double way_s =
      (*vehicle.range_ref_m - photodiode.position_m[0].mean) / vehicle.speed.speed_mps;
  const double late_s = peak_s - vehicle.speed.time_s - way_s;
  const double doubt_s = kBefore_s + kWayShare * std::abs(way_s);
  return within_clip || (late_s < doubt_s && (cut_off || late_s > -doubt_s));
}

}  // namespace

void add_unseen_passes(const Site& site, std::span<const PowerTrace> traces, const SeenClip& clip,
                       std::vector<VehicleResult>& vehicles, RunSummary& summary) {
  if (traces.empty()) return;
  std::int64_t unseen = 0;
  std::vector<PowerPass> outside, after;
  for (const PowerPass& pass : passes_of(traces)) {
    const PhotodiodeSite& photodiode = site.photodiodes[static_cast<std::size_t>(pass.photodiode)];
    const double peak_s = pass.peak_s + photodiode.time_offset_s.mean;
    if (std::ranges::any_of(vehicles, [&](const VehicleResult& vehicle) {
          return lights(vehicle, peak_s, pass.cut_off, photodiode, clip.end_s);
        }))
      continue;
    if (peak_s < 0.0 || peak_s > clip.end_s) {
      outside.push_back(pass);
      if (peak_s > clip.end_s) after.push_back(pass);
      continue;
    }
    ++unseen;
    summary.warnings.push_back(photodiode.id + ": light as of a passing vehicle at " +
                               fixed_text(peak_s, 2) +
                               " s, but the camera saw none near that time; it has no speed, check "
                               "the camera's view");
  }
  summary.counts["passes_unseen_by_camera"] = unseen;
  summary.counts["passes_outside_clip"] = static_cast<std::int64_t>(outside.size());
  if (outside.empty()) return;
  const std::string text = std::to_string(outside.size()) + " of the vehicles that passed the " +
                           "photodiodes did so before or after the clip (0 to " +
                           fixed_text(clip.end_s, 2) + " s); ";
  if (!clip.truncated || after.empty()) {
    summary.warnings.push_back(text + "a run of the trace alone measures them");
    return;
  }
  summary.warnings.push_back(text +
                             "as it ends early, those after it are measured by their light alone");
  int last_id = 0;
  for (const VehicleResult& vehicle : vehicles) last_id = std::max(last_id, vehicle.track_id);
  for (const PowerPass& pass : after) {
    throw_if_interrupted();
    vehicles.push_back(estimate_pass(pass, ++last_id, site, traces));
  }
}

}  // namespace vildar
