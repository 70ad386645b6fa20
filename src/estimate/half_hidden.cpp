#include "estimate/half_hidden.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>
#include <ranges>
#include <utility>
#include <vector>

#include "core/clock.h"
#include "core/median.h"
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

using LampOf = std::optional<LampSighting> VehicleSighting::*;

// One lamp of a pair goes behind something while the other is seen on: as long as it is being
// covered, what is left of it lies to one side of its middle, and has less light than it had beside
// the other before. Those sightings lose it.
template <class Sightings>
void leave_out_where_covered(Sightings&& sightings, LampOf lamp, LampOf other) {
  constexpr double kGoesOn_s = 0.4, kCovered_ln = 0.4, kWhole_ln = 0.1;
  constexpr std::ptrdiff_t kFewest = 20, kBeside = 2, kFirst = 4;
  std::vector<VehicleSighting*> pairs;
  std::vector<double> ratios_ln;
  double goes_on_s = 0.0;
  for (VehicleSighting& sighting : sightings) {
    if (shows_two(sighting)) {
      pairs.push_back(&sighting);
      ratios_ln.push_back(lamp == &VehicleSighting::left ? log_ratio(sighting)
                                                         : -log_ratio(sighting));
      goes_on_s = 0.0;
    } else if (!pairs.empty() && sighting.*other && !(sighting.*lamp) && !sighting.both_in_one) {
      goes_on_s = std::abs(seconds_of(sighting.time) - seconds_of(pairs.back()->time));
    }
  }
  const std::ptrdiff_t count = std::ssize(pairs);
  if (count < kFewest || goes_on_s < kGoesOn_s) return;
  const auto about_ln = [&](std::ptrdiff_t k) {
    return median(std::vector<double>(ratios_ln.begin() + std::max(k - kBeside, std::ptrdiff_t{0}),
                                      ratios_ln.begin() + std::min(k + kBeside + 1, count)));
  };
  const double whole_ln =
      median(std::vector<double>(ratios_ln.begin(), ratios_ln.begin() + count / kFirst));
  if (about_ln(count - 1 - kBeside) > whole_ln - kCovered_ln) return;
  std::ptrdiff_t whole = count;
  while (whole > count / kFirst && about_ln(whole - 1) < whole_ln - kWhole_ln) --whole;
  if (whole == count / kFirst) return;
  for (std::ptrdiff_t k = whole; k < count; ++k)
    (pairs[static_cast<std::size_t>(k)]->*lamp).reset();
}

}  // namespace

VehicleTrack without_half_hidden(VehicleTrack track) {
  // Fewer are strays to the fit.
  constexpr int kFewest = 5, kShare = 5, kUnlikeShare = 10;
  if (track.single_lamp) return without_hidden_ends(std::move(track));
  for (const auto& [lamp, other] : {std::pair{&VehicleSighting::left, &VehicleSighting::right},
                                    std::pair{&VehicleSighting::right, &VehicleSighting::left}}) {
    leave_out_where_covered(track.sightings, lamp, other);
    leave_out_where_covered(std::views::reverse(track.sightings), lamp, other);
  }
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
