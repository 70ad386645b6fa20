#pragma once

#include "core/random.h"
#include "synth/random_scene.h"
#include "types/site.h"

namespace vildar {

/// What the site file of a random scene tells, priors included.
Site told_site(ScenePreset preset, Random& random);

/// A site that those priors allow: every uncertain quantity drawn once and known. Left as told:
/// lanes, lamps and the gain of the channel, which differ from vehicle to vehicle.
Site drawn_site(const Site& told, Random& random);

}  // namespace vildar
