#pragma once

#include <span>

#include "estimate/delay_fit.h"

namespace vildar {

/// The pulses of one vehicle on two photodiodes, between two clip times, or up to each one's peak.
/// Sigmas follow the scatter within the blocks, which grows with the light where shot noise
/// does.
/// Misses: those of pair_pose(), too_few_samples, below_noise, bad_fit (edges leave the two
/// different stretches of the light, or one saw far less of it).
Outcome<DelayProblem> delay_problem(const Site& site, const PowerTrace& one,
                                    const PowerTrace& other, double from_s, double to_s,
                                    bool to_peak);

/// The surest speed over all pairs of traces, between two clip times, of those at which it is asked
/// for (see DelayProblem). Misses as above and those of fit_delay(); with fewer than two traces
/// no_scale.
Outcome<DelayFit> delay_speed(const Site& site, std::span<const PowerTrace* const> traces,
                              double from_s, double to_s, double asked_from_s = -INFINITY,
                              double asked_to_s = INFINITY);

/// Its row of methods.csv.
MethodResult delay_row(const Outcome<DelayFit>& outcome);

}  // namespace vildar
