#pragma once

#include <vector>

#include "track/lamp.h"
#include "track/road_view.h"
#include "types/blob.h"

namespace vildar {

/// The blobs of a frame as marks to follow. A wet road draws the image of a lamp out toward the
/// viewer: a blob much taller than wide is such a streak where a lamp shines above it, and a lamp
/// run together with its streak where none does, in which case the lamp is at its top. Such a
/// lamp, and one with light right below it, is known the less in height. Blobs that the lens model
/// cannot place are left out.
std::vector<Spot> spots_of(const BlobFrame& frame, const RoadView& view);

}  // namespace vildar
