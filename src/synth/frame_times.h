#pragma once

#include <cstdint>
#include <vector>

#include "synth/scenario.h"

namespace vildar {

/// Clip time of every picture that arrives, increasing, the first at 0.
std::vector<double> frame_times_s(const Scenario& scenario);

/// Pictures that arrive.
std::int64_t frame_count(const Scenario& scenario);

/// Whether pictures are not evenly spaced.
bool frames_uneven(const Scenario& scenario);

/// Ticks a second of the clock that stamps unevenly spaced pictures; Matroska knows no finer.
inline constexpr int kUnevenTicks_hz = 1000;

}  // namespace vildar
