#pragma once

#include <vector>

#include "types/power.h"
#include "types/site.h"

namespace vildar {

/// One trace in watts for each channel of the recording, in the order of the site's photodiodes.
///
/// Channels are matched to the site's photodiodes by id; a single channel without a name belongs to
/// the first. A photodiode of the site without a channel has no trace. Left out, and counted in
/// PowerTrace::rejected:
/// - `not_a_number`: empty, NaN or infinite cells;
/// - `out_of_order` and `repeated`: the fewest samples whose removal leaves times strictly
/// increasing;
/// - `clipped`: samples at an end of the range. The ends come from `full_scale_v`, for
///   whole-numbered counts also from 0 and from a maximum that is the top code of a converter;
///   where neither is known, runs of 5 or more exactly equal samples at the trace's maximum count
///   as clipped, or at its minimum where the samples beside them show noise; longer ones where the
///   converter makes neighbours equal anyhow (its minimum then counts as dark);
/// - `stuck`: a value held for 0.05 s or more, longer than the noise about it allows (a hang), and
///   runs as above of a minimum that no other sample comes near (a sensor that was unplugged);
/// - `negative`: samples below zero by far more than the noise and the darkest part explain;
/// - `spike`: one or two samples that stand out of those about them as no light of a vehicle does;
/// - `flash`: of lightning or a camera, for twice the time until the light is what it was.
///
/// `ambient_w` is the level of the darkest part of the trace in 50 ms means (whole periods of 100
/// and 120 Hz flicker), or in denser traffic its surest lowest floor; `ambient_sigma_w` covers the
/// light of vehicles that may be near throughout, and of one that is seen to come later. Throws
/// InputError, naming the id or the site key, where a channel matches no photodiode or a factor
/// that turns its quantity into watts is missing. A recording moved in is cleaned where it lies:
/// to copy it takes longer than all the rest.
std::vector<PowerTrace> condition(PhotodiodeRecording recording, const Site& site);

/// Means over consecutive blocks of `block_s` from `from_s` up to `to_s`, photodiode clock. A block
/// that a gap (more than 2.5 sample periods) cuts keeps its longest unbroken part and is dropped
/// where that is under half of it; times are those of the middle of what was used, sigmas those of
/// white noise and of rounding. Throws std::invalid_argument unless block_s > 0 and
/// from_s <= to_s, both finite.
std::vector<PowerBlock> block_means(const PowerTrace& trace, double from_s, double to_s,
                                    double block_s);

/// Stretches in which light stands out of the ambient level: 20 ms means (longer below 200 Hz)
/// above ambient by 6 sigma of a mean and 2 % of the brightest within 30 s, followed on both sides
/// down to half of that, at least 0.1 s long. One stretch is split where, between two maxima, light
/// falls below 0.4 of the lower of them; a gap of more than 1 s ends it. In order of time, not
/// overlapping.
std::vector<PowerPass> find_passes(const PowerTrace& trace);

}  // namespace vildar
