#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/clock.h"
#include "core/text.h"
#include "estimate/bearing_fit.h"
#include "estimate/hypotheses.h"

namespace vildar {
namespace {

// A part of a track, as shares of its time.
struct Part {
  double from, to;

  double length() const { return to - from; }
};

VehicleTrack part_of(const VehicleTrack& track, const Part& part) {
  const double from_s = seconds_of(track.sightings.front().time);
  const double length_s = seconds_of(track.sightings.back().time) - from_s;
  VehicleTrack cut = track;
  std::erase_if(cut.sightings, [&](const VehicleSighting& sighting) {
    const double share = (seconds_of(sighting.time) - from_s) / length_s;
    return share < part.from || share > part.to;
  });
  return cut;
}

// Lone lights before a pair may be another vehicle's, or glints: what both lamps were seen in
// counts.
bool holds_most_pairs(const VehicleTrack& part, const VehicleTrack& track) {
  const auto pairs = [](const VehicleTrack& of) {
    return std::ranges::count_if(of.sightings, [](const VehicleSighting& sighting) {
      return sighting.left && sighting.right;
    });
  };
  return 2 * pairs(part) >= pairs(track);
}

double relative_sigma(const Trajectory& trajectory) {
  const MotionState state =
      trajectory.at(best_time_s(trajectory, trajectory.from_s, trajectory.to_s));
  return state.speed_std_mps / std::abs(state.over_ground_mps);
}

// The surest fit of the longest parts of a track that the model explains: a lamp was hidden or
// another's for a while, or the vehicle began to brake. Less than half a track proves nothing.
std::optional<BearingFit> steady_part(const VehicleTrack& track, const Camera& camera,
                                      const Site& site) {
  constexpr int kFewestFrames = 12;
  constexpr std::array<Part, 5> kLongestFirst{
      {{0.0, 0.667}, {0.333, 1.0}, {0.0, 0.5}, {0.25, 0.75}, {0.5, 1.0}}};
  std::optional<BearingFit> best;
  double best_length = 0.0;
  for (const Part& part : kLongestFirst) {
    if (best && part.length() < best_length - 0.01) break;
    const VehicleTrack cut = part_of(track, part);
    if (!holds_most_pairs(cut, track)) continue;
    auto outcome = fit_bearings(cut, camera, site);
    BearingFit* fit = std::get_if<BearingFit>(&outcome);
    if (!fit || !fit->steady() || fit->trajectory.frames < kFewestFrames) continue;
    if (best && relative_sigma(fit->trajectory) > relative_sigma(best->trajectory)) continue;
    best = std::move(*fit);
    best_length = part.length();
  }
  return best;
}

}  // namespace

Outcome<std::vector<Trajectory>> fit_trajectories(const VehicleTrack& track, const Camera& camera,
                                                  const Site& site,
                                                  std::vector<std::string>& warnings) {
  auto outcome = fit_bearings(track, camera, site);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) return *miss;
  BearingFit& first = std::get<BearingFit>(outcome);
  if (!first.steady()) {
    auto part = steady_part(track, camera, site);
    if (!part && !first.explains()) return Miss::bad_fit;
    if (part) {
      first = std::move(*part);
      warnings.push_back("its motion or its lamps change in view: measured from " +
                         fixed_text(first.trajectory.from_s, 2) + " to " +
                         fixed_text(first.trajectory.to_s, 2) + " s alone");
    }
  }
  Trajectory& seen = first.trajectory;
  if (!seen.ego.covers(seen.from_s, seen.to_s))
    warnings.push_back("the ego speed trace does not span the whole track; its end speed is held");
  if (track.kind == LampKind::taillamp &&
      !(site.lamps.tail_height_m && site.lamps.tail_separation_m))
    warnings.push_back(
        "tail lamps: the site file has no lamps.tail_height_m or no tail_separation_m; the "
        "headlamps' mean was taken with a std of at least 0.2 m");
  seen.problem.sigma_factor = first.check.sigma_factor.cwiseMax(1.0);
  if (first.scaled) return fit_hypotheses(seen, first.readings, site, track.direction);
  const auto again = fit_geometry(seen.problem, seen.fit.parameters);
  if (const Miss* miss = std::get_if<Miss>(&again)) return *miss;
  seen.fit = std::get<GeometryFit>(again);
  return std::vector{std::move(seen)};
}

}  // namespace vildar
