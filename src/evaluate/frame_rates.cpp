#include "evaluate/frame_rates.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace vildar {
namespace {

using Times = std::map<std::int64_t, double>;  // s, by frame

Times times_of(std::span<const TruthVehicle> truth) {
  Times times_s;
  for (const TruthVehicle& vehicle : truth)
    for (const TruthSighting& sighting : vehicle.sightings)
      if (sighting.lamps.any()) times_s.emplace(sighting.frame, sighting.t_s);
  return times_s;
}

Times times_of(std::span<const RunVehicle> run) {
  Times times_s;
  for (const RunVehicle& vehicle : run)
    for (const RunSighting& sighting : vehicle.sightings)
      if (sighting.t_s) times_s.emplace(sighting.frame, *sighting.t_s);
  return times_s;
}

bool rates_differ(const Times& truth_s, const Times& run_s) {
  constexpr double kAlike = 0.02;
  std::vector<std::pair<double, double>> both_s;
  for (const auto& [frame, time_s] : truth_s)
    if (const auto found = run_s.find(frame); found != run_s.end())
      both_s.emplace_back(time_s, found->second);
  if (both_s.size() < 2) return false;
  const double truth_took_s = both_s.back().first - both_s.front().first;
  const double run_took_s = both_s.back().second - both_s.front().second;
  return std::abs(run_took_s - truth_took_s) > kAlike * std::max(truth_took_s, run_took_s);
}

}  // namespace

std::optional<std::vector<RunVehicle>> numbered_by_time(std::span<const TruthVehicle> truth,
                                                        std::span<const RunVehicle> run) {
  constexpr double kNear = 0.25;  // of the truth's step
  const Times truth_s = times_of(truth);
  if (!rates_differ(truth_s, times_of(run))) return std::nullopt;
  std::map<double, std::int64_t> frame_at;
  for (const auto& [frame, time_s] : truth_s) frame_at.emplace(time_s, frame);
  double step_s = std::numeric_limits<double>::infinity();
  for (auto at = frame_at.begin(); std::next(at) != frame_at.end(); ++at)
    step_s = std::min(step_s, std::next(at)->first - at->first);
  std::vector<RunVehicle> numbered(run.begin(), run.end());
  for (RunVehicle& vehicle : numbered) {
    std::map<std::int64_t, std::pair<double, RunSighting>> nearest;
    for (const RunSighting& sighting : vehicle.sightings) {
      if (!sighting.t_s) continue;
      auto at = frame_at.lower_bound(*sighting.t_s);
      if (at == frame_at.end() || (at != frame_at.begin() && *sighting.t_s - std::prev(at)->first <
                                                                 at->first - *sighting.t_s))
        --at;
      const double off_s = std::abs(at->first - *sighting.t_s);
      if (off_s > kNear * step_s) continue;
      const auto [entry, is_new] = nearest.try_emplace(at->second, off_s, sighting);
      if (!is_new && off_s < entry->second.first) entry->second = {off_s, sighting};
      entry->second.second.frame = at->second;
    }
    vehicle.sightings.clear();
    for (auto& [frame, seen] : nearest) vehicle.sightings.push_back(std::move(seen.second));
  }
  return numbered;
}

}  // namespace vildar
