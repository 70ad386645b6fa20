#pragma once

#include "detect/photometry.h"

namespace vildar {

/// Mean colour of a light's rim, where luma does not clip.
struct RimColour {
  bool known = false;
  double cr = 0.0;
  double cb = 0.0;
  double luma_code = 0.0;  ///< mean
  double chance = 0.0;     ///< see Blob::colour_chance
};

/// Colour of the unclipped pixels in and around `box` that are at least `level_code`; unknown for
/// grey frames and where there is no such pixel.
RimColour rim_colour(const Frame& frame, const PixelBox& box, int level_code, int clip_code);

/// The colour of a light that does not clip as it would be were it bright: colour differences grow
/// with the luma by which a light outshines its surroundings, `background_code`, up to 0.4 of
/// `clip_code`. What coding leaves to chance is not enlarged as much.
RimColour own_colour(const RimColour& rim, int background_code, int clip_code);

/// Whether a peak is as sharp, and as bright (linear) against the light around it, as a lamp is;
/// one that is red needs to outshine it less. `px_per_usual`: see optics/picture.h.
bool like_a_lamp(const Peak& peak, const Measured& light, double peak_linear, double red_log_odds,
                 double px_per_usual);

/// What a light is, from one frame: `other` where it is not as sharp a peak as a lamp is.
LampKind kind_of(const Peak& peak, const Measured& light, double peak_linear, const RimColour& rim,
                 double px_per_usual);

}  // namespace vildar
