#include "estimate/delay_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <vector>

#include "estimate/light_checks.h"
#include "estimate/speed_gate.h"

namespace vildar {
namespace {

constexpr double kMostWanderChi2 = 15.0;

// Light about each peak that is brighter than this share of it.
DelayProblem bright_part(DelayProblem problem, double share) {
  for (DelaySide* side : {&problem.near, &problem.far}) {
    std::vector<PowerBlock>& blocks = side->blocks;
    const auto peak = std::ranges::max_element(blocks, {}, &PowerBlock::power_w);
    const double least_w = side->ambient_w.mean + share * (peak->power_w - side->ambient_w.mean);
    const auto faint = [&](const PowerBlock& block) { return block.power_w < least_w; };
    const auto end = std::find_if(peak, blocks.end(), faint);
    const auto first = std::find_if(std::make_reverse_iterator(peak), blocks.rend(), faint).base();
    blocks = std::vector<PowerBlock>(first, end);
  }
  return problem;
}

constexpr std::array kParts{0.05, 0.1, 0.2, 0.4};  // of the peak

Outcome<DelayFit> fit_asked_at(DelayProblem problem, double time_s) {
  problem.asked_from_s = problem.asked_to_s = time_s;
  return fit_delay(problem);
}

// By how much `part` is faster than `fit` says of its time.
double faster_mps(const DelayFit& part, const DelayFit& fit) {
  return part.speed.speed_mps - fit.speed.speed_mps -
         fit.acceleration_mps2 * (part.speed.time_s - fit.speed.time_s);
}

bool same_speed(const DelayFit& part, const DelayFit& fit) {
  constexpr double kSigmas = 2.0;
  return std::abs(faster_mps(part, fit)) <
         kSigmas * std::hypot(part.own_std_mps(), fit.own_std_mps());
}

bool same_acceleration(const DelayFit& one, const DelayFit& other) {
  constexpr double kSigmas = 2.0;
  return std::abs(one.acceleration_mps2 - other.acceleration_mps2) <
         kSigmas * std::hypot(one.acceleration_std_mps2, other.acceleration_std_mps2);
}

// What the parts brighter than `share` say of the same time.
struct BrighterParts {
  std::vector<DelayFit> fits;
  double brightest = 0.0;  ///< share of the peak from which on the brightest of them is
};
BrighterParts brighter_parts(const DelayProblem& problem, const DelayFit& fit, double share) {
  BrighterParts found;
  for (const double part : kParts) {
    if (part <= share) continue;
    const auto outcome = fit_asked_at(bright_part(problem, part), fit.speed.time_s);
    const auto* other = std::get_if<DelayFit>(&outcome);
    if (!other) continue;
    found.fits.push_back(*other);
    found.brightest = part;
  }
  return found;
}

// By how much they say something else, beyond what noise lets quiet ones say: that of other lights
// which one curve and a steady acceleration happened to take in.
double spread_mps(const DelayFit& fit, const std::vector<DelayFit>& parts) {
  double most_mps = 0.0;
  for (const DelayFit& part : parts) {
    const double apart_mps = std::abs(faster_mps(part, fit));
    const double noise_mps = is_quiet(part) ? std::min(part.own_std_mps(), apart_mps) : 0.0;
    most_mps = std::max(most_mps, std::sqrt(apart_mps * apart_mps - noise_mps * noise_mps));
  }
  return most_mps;
}

}  // namespace

bool vehicles_drive_so(const DelayFit& fit) {
  return fit.mean_acceleration_mps2 > -kHardestBraking_mps2 &&
         fit.mean_acceleration_mps2 < kHardestSpeedingUp_mps2;
}

bool is_alike(const DelayFit& fit) {
  constexpr double kAlikeChi2 = 1.5, kAlikeFactor = 1.5;
  return fit.chi2_per_dof < kAlikeChi2 && fit.sigma_factor < kAlikeFactor;
}

bool is_quiet(const DelayFit& fit) {
  return is_alike(fit) && fit.wander_chi2 < kMostWanderChi2 && vehicles_drive_so(fit);
}

std::optional<QuietPart> quiet_part(const DelayProblem& problem) {
  for (const double share : kParts) {
    const auto outcome = fit_delay(bright_part(problem, share));
    const auto* fit = std::get_if<DelayFit>(&outcome);
    if (fit && is_quiet(*fit))
      return QuietPart{*fit, spread_mps(*fit, brighter_parts(problem, *fit, share).fits)};
  }
  return std::nullopt;
}

std::optional<double> spread_of_parts_mps(const DelayProblem& problem, const DelayFit& fit) {
  constexpr double kBright = 0.2;
  const BrighterParts parts = brighter_parts(problem, fit, 0.0);
  if (parts.brightest < kBright) return std::nullopt;
  return spread_mps(fit, parts.fits);
}

bool agrees(const DelayProblem& problem, const DelayFit& part) {
  const auto outcome = fit_asked_at(problem, part.speed.time_s);
  const auto* whole = std::get_if<DelayFit>(&outcome);
  return whole && same_speed(part, *whole);
}

void widen_for_others(const DelayProblem& problem, DelayFit& fit) {
  if (!(fit.wander_chi2 > kMostWanderChi2)) return;
  if (std::ranges::all_of(brighter_parts(problem, fit, 0.0).fits, [&](const DelayFit& part) {
        return same_speed(part, fit) && same_acceleration(fit, part);
      }))
    return;
  widen(fit, std::sqrt(fit.wander_chi2 / kMostWanderChi2 - 1.0) * fit.own_std_mps());
}

}  // namespace vildar
