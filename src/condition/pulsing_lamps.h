#pragma once

#include "types/power.h"

namespace vildar {

/// Where lamps pulse (LEDs dimmed by pulse-width modulation, 80 Hz and faster), puts in the place
/// of their samples what light they give on average: over each period, of the level while they are
/// on and of that while they are off, in the shares of time that edges over many periods tell.
/// The average of the samples themselves would not do: of one instant each, they fall into pulses
/// now more, now less often, and the slow beat bends the rise of the light. Samples that are means
/// over their period (seen by those between the levels) are averaged over whole periods of the
/// lamps where they are too few to show either level.
///
/// Needs `noise_sigma_w` and `sample_period_s`. A stretch stays as it is where its light is not of
/// two levels at one frequency (mains flicker, two such vehicles equally strong), where a lamp is
/// on or off for less than a sample, and where the trace has gaps. Notes what it evened out in
/// `trace.pulsing`. Source: docs/light.md.
void even_out_pulses(PowerTrace& trace);

}  // namespace vildar
