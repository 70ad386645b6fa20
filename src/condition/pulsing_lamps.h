#pragma once

#include "types/power.h"

namespace vildar {

/// Where lamps pulse (LEDs dimmed by pulse-width modulation, 80 Hz and faster), puts in the place
/// of their samples what light they give on average: over each period, of the level while they are
/// on and of that while they are off, in the shares of time that edges over many periods tell.
/// The average of the samples themselves would not do: of one instant each, they fall into pulses
/// now more, now less often, and the slow beat bends the rise of the light. Samples that are means
/// over their spacing (seen by those between the levels) are averaged over whole periods of the
/// lamps where they are too few to show either level.
///
/// Needs `noise_sigma_w` and `sample_period_s`. What pulses on end is evened out whole or stays as
/// it is: that with gaps, of lamps on or off for less than a sample, without two steady levels at
/// one frequency (slow edges, two lamps, clipped pulses), and what jumps by less than four times as
/// far as the light flickers between, as with the mains.
/// Notes what it evened out in `trace.pulsing`; mains flicker of other light, of `mains_hz`
/// nominally, goes before that, as remove_flicker() does it. Source: docs/light.md.
void even_out_pulses(PowerTrace& trace, double mains_hz = 50.0);

}  // namespace vildar
