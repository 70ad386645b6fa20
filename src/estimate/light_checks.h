#pragma once

#include "estimate/delay_fit.h"
#include "types/power.h"

namespace vildar {

/// Whether single samples scatter about the smooth rise to a peak by more than noise and a
/// twentieth of the light: as those of lamps do that pulse, whose slow aliases then bend the rise
/// unseen. Times are the trace's own.
bool pulses(const PowerTrace& trace, double from_s, double peak_s);

/// Whether the vehicle stands for a while on its way to the peak: light that stays within 2 %
/// for 1.2 s, by means of 50 ms that noise moves by 0.4 % at most, is brighter by 0.3 (ln) later,
/// and was as much less bright before. Times are the trace's own.
bool stands(const PowerTrace& trace, double from_s, double peak_s);

/// Of a delay's speed, one sigma, where others have this share of the peak: their light draws it
/// towards their speeds, of the rise their share is about twice as large, and speeds of neighbours
/// differ by 15 %.
double others_std_mps(double share, double speed_mps);

/// Adds an error of the speed that the fit knows nothing of, one sigma.
void widen(DelayFit& fit, double std_mps);

/// Of a delay's speed, one sigma, where lamps pulse between two times of the trace: their light is
/// known when they are on, and the end of it to within some part of a sample.
double pulsing_std_mps(const PowerTraceFacts& trace, double from_s, double to_s, double baseline_m,
                       double speed_mps);

/// Whether the light is not that of one vehicle with steady lamps: no curve that moves leaves slow
/// structure so much larger than noise, and none brakes or speeds up so hard. Two abreast in two
/// lanes, whose mixture moves at neither's speed, look like one whose acceleration changes, more
/// than what is left of the light when it is past explains. `lanes`: that it may drive in.
bool of_several(const DelayFit& fit, std::size_t lanes, double others_share);

/// Standard deviation of ln of the light of a stretch, one factor for all of it: of lamps whose
/// duty samples of single instants do not tell. Zero where nothing pulses. Times are the trace's
/// own.
double log_light_std(const PowerTraceFacts& trace, double from_s, double to_s);

/// Whether more of this time, as far as the trace goes, was clipped than not; photodiode clock.
bool is_mostly_clipped(const PowerTrace& trace, double from_s, double to_s);

}  // namespace vildar
