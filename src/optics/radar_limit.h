#pragma once

#include "core/quantity.h"
#include "optics/incidence.h"

namespace vildar {

/// What a noiseless radar or lidar measures, as a share of the true speed (1: exact). The paper's
/// "cosine effect": it sees the speed along its line of sight alone.

/// Straight road: cos(theta), eq. (23).
double radar_share_straight(Metres range, Metres perpendicular);

/// Curved road at arc angle beta, eq. (24).
double radar_share_curved(const PaperCurve& curve, Radians arc_angle);

/// Straight road, averaged over the same window that the light-based estimator is given: from
/// range + travelled to range. The mean of cos(theta) over equal times, [D(start) - D(end)] /
/// travelled. Throws std::domain_error unless travelled > 0.
double radar_share_straight_window(Metres range, Metres travelled, Metres perpendicular);

/// The same radar told a perpendicular distance, as the light-based estimator is: it knows its
/// distance D from the echo, hence cos(theta) = sqrt(1 - d^2 / D^2), and divides by it. Exact where
/// `assumed` is the true one. Throws std::domain_error unless the vehicle is ahead and D > assumed.
double radar_share_corrected(Metres range, Metres perpendicular, Metres assumed);

}  // namespace vildar
