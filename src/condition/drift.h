#pragma once

#include "types/power.h"

namespace vildar {

/// Takes slow and lasting changes of the ambient light out of the samples: dusk, a cloud, a street
/// lamp that switches on. What is left has one level, `ambient_w`, and `drift_w` says how far it
/// ranged before.
///
/// The level is that of the dark stretches: those near the floor, the highest curve under the trace
/// that nothing shorter than 30 s can lift, and longer ones (from 5 s) in which a cubic follows the
/// light but for vehicles on top of it. Between them it is interpolated. A vehicle's pass is
/// shorter, unless it is slower than 1.5 m/s, and never a cubic. Traces under 30 s, of less than 20
/// samples a second, or without any dark stretch stay as they are. So do those whose dark stretches
/// differ by no more than what the vehicles before and after them may light from afar, as a power
/// law growing towards their passing: in dense traffic the ambient is never seen alone.
/// `sample_period_s` and `noise_sigma_w` must be set.
void remove_drift(PowerTrace& trace);

}  // namespace vildar
