#pragma once

#include <cstdint>
#include <functional>

namespace vildar::simulate {

/// Calls `trial(index)` for 0 <= index < trials on `threads` threads (0: as many as the machine
/// has). Results must go to places of their own; then nothing depends on the number of threads. The
/// first exception of a trial is thrown again after all threads have ended.
void for_each_trial(int trials, int threads, const std::function<void(int)>& trial);

/// A seed that differs for every experiment, series and trial.
std::uint64_t trial_seed(std::uint64_t seed, std::uint64_t stream, int trial);

}  // namespace vildar::simulate
