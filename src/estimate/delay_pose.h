#pragma once

#include <span>
#include <vector>

#include "core/outcome.h"
#include "core/quantity.h"
#include "types/site.h"

namespace vildar {

/// By how much two photodiodes receive unlike light of a vehicle that is as far ahead of one as of
/// the other along its lane.
struct UnlikeLight {
  double ahead_m = 0.0;
  double log_ratio = 0.0;  ///< ln of what `far` receives over what `near` does
  double doubt = 0.0;      ///< sigma of it: lamps and lanes differ
};

/// At what angle off its axis a photodiode receives light from so far ahead: -ln of its cosine.
struct OffAxis {
  double ahead_m = 0.0, log_secant = 0.0;
};

/// How two photodiodes stand to each other as seen from the lanes of a straight or curved road.
struct PairPose {
  Uncertain baseline_m;             ///< of the vehicle's way, positive
  double perpendicular_m = 0.0;     ///< from the path of the lamps to the photodiodes
  std::vector<UnlikeLight> unlike;  ///< by rising distance; empty: alike wherever light comes from
  std::vector<OffAxis> off_axis;    ///< of light from the first lane, by rising distance
};

/// `near` is passed last. On a bend each lane's way past both is another, and photodiodes that look
/// the same way in the road frame do not look the same way along the road: what that makes of the
/// light follows from the receivers' cosine and the range, and from headlamps' beams as far as they
/// are alike. Misses: outside_model (they stand so unlike that light differs by more than 15 %, or
/// by an amount unknown to 10 %; a bend that begins ahead of them, or of unknown radius), no_scale
/// (less than 10 cm apart along the road).
Outcome<PairPose> pair_pose(const Site& site, const PhotodiodeSite& near,
                            const PhotodiodeSite& far);

/// Linear between the distances; beyond them that of the nearest. Alike where there are none.
UnlikeLight unlike_at(std::span<const UnlikeLight> unlike, double ahead_m);

/// -ln of the cosine, likewise.
double log_secant_at(std::span<const OffAxis> off_axis, double ahead_m);

}  // namespace vildar
