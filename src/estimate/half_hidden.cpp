#include "estimate/half_hidden.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <ranges>
#include <utility>
#include <vector>

#include "core/clock.h"
#include "core/robust_line.h"

namespace vildar {
namespace {

constexpr double kAlike = std::numbers::ln2;

bool shows_two(const VehicleSighting& sighting) {
  return sighting.left && sighting.right && !sighting.both_in_one;
}

// Of the left lamp's light over the right one's.
double log_ratio(const VehicleSighting& sighting) {
  constexpr double kLeastFlux = 1e-9;
  return std::log(std::max(sighting.left->flux, kLeastFlux) /
                  std::max(sighting.right->flux, kLeastFlux));
}

// How many sightings of a lone lamp, from one end on, show less light than those within a second
// after it ask for: it comes out from behind something, or goes there.
template <class Sightings>
std::ptrdiff_t hidden_of(const Sightings& sightings) {
  constexpr double kBeside_s = 1.0, kHidden_ln = 0.25, kLeastFlux = 1e-9;
  auto at = sightings.begin();
  for (; at != sightings.end(); ++at) {
    std::vector<double> times_s, fluxes_ln;
    for (auto next = at; next != sightings.end(); ++next) {
      const double time_s = seconds_of(next->time) - seconds_of(at->time);
      if (std::abs(time_s) > kBeside_s) break;
      const auto& lamp = next->left ? next->left : next->right;
      if (!lamp) continue;
      times_s.push_back(time_s);
      fluxes_ln.push_back(std::log(std::max(lamp->flux, kLeastFlux)));
    }
    constexpr std::size_t kFewest = 5;
    if (times_s.size() < kFewest ||
        fluxes_ln.front() > least_deviations_line(times_s, fluxes_ln).at_zero - kHidden_ln)
      break;
  }
  return at - sightings.begin();
}

VehicleTrack without_hidden_ends(VehicleTrack track) {
  auto& sightings = track.sightings;
  const auto first = hidden_of(sightings);
  const auto last = hidden_of(std::views::reverse(sightings));
  constexpr std::ptrdiff_t kMostShare = 4;  // one in so many
  if (kMostShare * (first + last) > std::ssize(sightings)) return track;
  sightings.erase(sightings.end() - last, sightings.end());
  sightings.erase(sightings.begin(), sightings.begin() + first);
  return track;
}

}  // namespace

VehicleTrack without_half_hidden(VehicleTrack track) {
  // Fewer are strays to the fit.
  constexpr int kFewest = 5, kShare = 5, kUnlikeShare = 10;
  if (track.single_lamp) return without_hidden_ends(std::move(track));
  int pairs = 0, alike = 0;
  for (const VehicleSighting& sighting : track.sightings) {
    if (!shows_two(sighting)) continue;
    ++pairs;
    alike += std::abs(log_ratio(sighting)) < kAlike;
  }
  const int unlike = pairs - alike;
  if (alike < kFewest || kShare * alike < pairs || unlike < kFewest ||
      kUnlikeShare * unlike < pairs)
    return track;
  for (VehicleSighting& sighting : track.sightings) {
    if (!shows_two(sighting)) continue;
    const double ratio = log_ratio(sighting);
    if (ratio < -kAlike) sighting.left.reset();
    if (ratio > kAlike) sighting.right.reset();
  }
  return track;
}

}  // namespace vildar
