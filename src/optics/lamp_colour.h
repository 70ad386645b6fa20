#pragma once

namespace vildar {

/// Natural log of the likelihood of a light's colour if it is a tail lamp's over that if it is a
/// headlamp's. `cr` and `cb` are means over the rim, where luma does not clip (of dim lights as
/// were they bright, see Blob), as fractions in
/// [-0.5, 0.5]; (0, 0), as of a grey picture, is a headlamp's. Source: docs/tracking.md.
double tail_lamp_log_odds(double cr, double cb);

/// Above this nothing but a tail lamp is that red.
inline constexpr double kSurelyRed = 3.0;

}  // namespace vildar
