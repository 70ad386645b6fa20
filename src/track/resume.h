#pragma once

#include "track/pairing.h"
#include "track/vehicle.h"

namespace vildar {

/// How long a vehicle that was lost within the picture may stay hidden, in seconds.
inline constexpr double kLongestWait_s = 3.5;

/// Whether a pair that has just been found stands where a vehicle that was lost from view, or taken
/// apart, would have got to: at its speed along the road, and as far across it; before a sensor
/// that moves, at its speed relative to that.
bool goes_on(const Vehicle& lost, const Vehicle& found, const RoadView& view);

/// The same of a light that was alone, and was lost no more than kLongestWait_s before the other
/// was found.
bool goes_on(const std::vector<LampRecord>& lost, const std::vector<LampRecord>& found,
             const RoadView& view);

/// The found vehicle takes over what was seen of the lost one.
void resume(const Vehicle& lost, Vehicle& found);

/// A pair that was found lately may be a vehicle that was lost shortly before, or whose lamps are
/// still looked for, or have gone over to other lights: that is cut, and waits from then on. Where
/// two would do, none is taken. Asked again as more is seen of a pair, and of every pair once after
/// `waits_since`, the frame in which another vehicle began to wait.
void resume_lost(Vehicles& vehicles, Vehicles& waiting, std::int64_t frame,
                 std::int64_t waits_since, const RoadView& view);

}  // namespace vildar
