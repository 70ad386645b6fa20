#pragma once

#include <optional>
#include <span>

#include "track/lamp.h"

namespace vildar {

/// What was seen of a light that has no partner.
struct LoneLight {
  double riding_share = 0.0;    ///< of the looks: moved as a part of a vehicle that has its lamps
  double mirrored_share = 0.0;  ///< drawn out like, or below another lamp like, its mirror image
  double clipped_share = 0.0;
  bool lamps_clip = false;  ///< those of this scene mostly do
  /// ln of its strength less that of strong lamps of this scene (LightScale), 0 at most where only
  /// one or two are known; nothing where none is.
  std::optional<double> strength_ln;
  double misshapen_share = 0.0;   ///< see below
  double unlike_share = 0.0;      ///< no sharp peak in the picture: LampKind::other
  double imaged_share = 0.0;      ///< a wet road showed its own image below it
  double paired_share = 0.0;      ///< of all its looks: as one of a pair that came apart
  double off_course_share = 0.0;  ///< see off_course_share()
  double unseen_share = 0.0;      ///< of the frames from its first to its last look
  double below_share = 0.0;       ///< in the column below another lamp, and moved along with it
};

/// Natural log of the odds that it is the lamp of a vehicle of its own, a motorcycle's or a car's
/// whose other lamp is dark or out of view, rather than a glint on a body, paint or lit road. The
/// cues count as independent given which of the two it is; docs/tracking.md says what is assumed.
double lone_lamp_log_odds(const LoneLight& light);

/// By a metre and 10 px, as lit road is.
bool wider_than_a_lamp(const LampRecord& record, double inverse_depth_per_m, const RoadView& view);

/// Share of the looks at which a light was of no lamp's shape: wider than a lamp, or of another
/// width than just before and after. Not the glare of a lamp: round, with three tenths of its box
/// clipped, and growing by less than half of what it comes nearer (logarithms).
double misshapen_share(std::span<const LampRecord> records, const RoadView& view);

}  // namespace vildar
