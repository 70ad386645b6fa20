#pragma once

#include <optional>

#include "estimate/delay_fit.h"
#include "estimate/joint_fit.h"

namespace vildar {

/// Bearings, and the speed and acceleration that two photodiodes found by their delay. No lamp,
/// beam or law is taken as known. `time_std_s` is the sigma of the photodiodes' clock against the
/// camera's. Misses: not_converged, unobservable, sensors_contradict (the two disagree by more than
/// four and a half sigmas).
Outcome<JointFit> fit_with_delay(const Trajectory& camera_only, const DelayFit& delay,
                                 double time_std_s);

}  // namespace vildar
