#include "estimate/half_hidden.h"

#include <algorithm>
#include <cmath>
#include <numbers>

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

}  // namespace

VehicleTrack without_half_hidden(VehicleTrack track) {
  // Fewer are strays to the fit.
  constexpr int kFewest = 5, kShare = 5, kUnlikeShare = 10;
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
