#pragma once

namespace vildar {

/// Natural log of the likelihood of a light's colour if it is a tail lamp's over that if it is a
/// headlamp's. `cr` and `cb` are means over the rim, where luma does not clip (of dim lights as
/// were they bright, see Blob), as fractions in
/// [-0.5, 0.5]; (0, 0), as of a grey picture, is a headlamp's. Source: docs/tracking.md.
double tail_lamp_log_odds(double cr, double cb);

/// Of how much of a dim light's colour is left where `chance` of it is coding's: it is drawn
/// towards grey by as much as lamps differ less than that.
double colour_kept(double chance);

/// The same odds of a colour of which so much was kept, by what it may as well have been: of what
/// coding leaves grey they are even in the end.
double faint_tail_lamp_log_odds(double cr, double cb, double chance);

/// Whether a dim light's colour tells tail lamps from headlamps; a bright one's always does.
bool colour_tells(double cr, double cb, double chance);

/// Above this nothing but a tail lamp is that red.
inline constexpr double kSurelyRed = 3.0;

}  // namespace vildar
