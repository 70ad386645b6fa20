#include "estimate/goes_on.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "estimate/offset.h"

namespace vildar {
namespace {

// The lamp's place at `time_s` as its last two steps carry it on, and how far that is from the
// last.
struct Carried {
  Eigen::Vector2d at_px;
  double step_px;
};

template <class Lamp>
std::optional<Carried> carried(const std::vector<TrackRow>& rows, Lamp lamp, double time_s) {
  constexpr std::size_t kBack = 2;
  const TrackRow &last = rows.back(), &before = rows[rows.size() - 1 - kBack];
  const auto &at = last.sighting.*lamp, &was = before.sighting.*lamp;
  if (!at || !was || !(before.time_s < last.time_s)) return std::nullopt;
  const Eigen::Vector2d step_px =
      (at->centre_px - was->centre_px) * (time_s - last.time_s) / (last.time_s - before.time_s);
  return Carried{at->centre_px + step_px, step_px.norm()};
}

}  // namespace

bool goes_on_as(const VehicleEstimate& earlier, const VehicleEstimate& later) {
  constexpr double kLongest_s = 0.15, kNear_px = 4.0, kNearPerStep = 0.3;
  constexpr std::size_t kFewest = 3;
  if (earlier.rows.size() < kFewest || later.rows.empty() ||
      earlier.result.direction != later.result.direction)
    return false;
  const TrackRow& first = later.rows.front();
  const double gap_s = first.time_s - earlier.rows.back().time_s;
  if (gap_s <= 0.0 || gap_s > kLongest_s) return false;
  // Of a vehicle that shows one lamp either may have been taken for its left.
  constexpr std::array kLamps{&VehicleSighting::left, &VehicleSighting::right};
  int expected_lamps = 0, seen_lamps = 0, met = 0;
  for (const auto lamp : kLamps) seen_lamps += (first.sighting.*lamp).has_value();
  for (const auto lamp : kLamps) {
    const auto expected = carried(earlier.rows, lamp, first.time_s);
    if (!expected) continue;
    ++expected_lamps;
    met += std::ranges::any_of(kLamps, [&](const auto other) {
      const auto& seen = first.sighting.*other;
      return seen && (seen->centre_px - expected->at_px).norm() <
                         kNear_px + kNearPerStep * expected->step_px;
    });
  }
  return met > 0 && met == std::min(expected_lamps, seen_lamps);
}

bool comes_out_again(const VehicleEstimate& earlier, const VehicleEstimate& later) {
  constexpr double kLongest_s = 1.5, kMostOff_m = 3.0, kMostBeside_m = 1.2, kMostSigma_m = 5.0;
  if (earlier.trajectories.empty() || later.trajectories.empty() ||
      earlier.result.direction != later.result.direction)
    return false;
  const Trajectory &a = earlier.trajectories.front(), &b = later.trajectories.front();
  const double from_s = earlier.result.t_last_s, to_s = later.result.t_first_s;
  if (to_s <= from_s || to_s - from_s > kLongest_s || a.lamps != b.lamps || a.lane != b.lane)
    return false;
  const Offset off = scaled_offset_at(earlier, later, 0.5 * (from_s + to_s));
  return off.sigma_m < kMostSigma_m && std::abs(off.along_m) < kMostOff_m &&
         std::abs(off.beside_m) < kMostBeside_m;
}

}  // namespace vildar
