#pragma once

#include "types/power.h"

namespace vildar {

/// Takes the flicker of mains-fed lamps, and hum, out of the samples: the mains frequency and its
/// multiples up to the eighth. Sets `mains_hz` and `flicker_w` of the trace where there was any.
///
/// `mains_hz` is the nominal frequency; the true one is found within 0.3 Hz of it and followed.
/// Where the trace flickers at the multiples of the other of 50 and 60 Hz instead, those are taken.
/// The strength may change within about a second; a vehicle's light is no flicker. Stay as they
/// are: a trace under 2 s, flicker that the converter's steps hide, any frequency that at this rate
/// is sampled like slow light (within 15 Hz of a multiple of half the rate), and all where that is
/// so of twice `mains_hz`. `sample_period_s` must be set, and what set_noise tells of noise.
/// Samples must be those of an instant or of a mean over a fixed time.
void remove_flicker(PowerTrace& trace, double mains_hz);

}  // namespace vildar
