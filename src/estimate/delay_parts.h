#pragma once

#include <optional>

#include "core/outcome.h"
#include "estimate/delay_fit.h"

namespace vildar {

/// Whether the mean acceleration is one that vehicles reach.
bool vehicles_drive_so(const DelayFit& fit);

/// Whether one curve and a motion explain the light of both photodiodes.
bool is_alike(const DelayFit& fit);

/// The same with a steady acceleration, as vehicles drive: nothing tells of light of others.
bool is_quiet(const DelayFit& fit);

struct QuietPart {
  DelayFit fit;
  double spread_mps = 0.0;  ///< as spread_of_parts_mps(), of the parts that are brighter still
};

/// Light of others that go another way, as of tail lamps, is the less beside a vehicle's own the
/// brighter that is: the most of it, from a twentieth of each peak on, that is_quiet().
std::optional<QuietPart> quiet_part(const DelayProblem& problem);

/// By how much the brighter parts of the light say another speed of the same time than `fit` does,
/// beyond what noise lets quiet ones say. Nothing where no part from a fifth of the peak on can be
/// fitted, in which others' light counts least.
std::optional<double> spread_of_parts_mps(const DelayProblem& problem, const DelayFit& fit);

/// Whether all of the light says of the time of `part` what that does: what wanders in all of it
/// is then the vehicle's own motion.
bool agrees(const DelayProblem& problem, const DelayFit& part);

/// Where no part is quiet: motion in `fit`, of all of the light, that brighter parts deny may be
/// light of others.
void widen_for_others(const DelayProblem& problem, DelayFit& fit);

}  // namespace vildar
