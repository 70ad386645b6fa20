#pragma once

#include <optional>
#include <span>

#include "types/result.h"
#include "types/site.h"

namespace vildar {

/// How wide, in metres, a light is that is no lamp: a lit window or sign. Where nothing clips, what
/// is seen is the light's own size; wider both ways than 0.45 m in most of the pictures that tell
/// (12 px and more, at a range that is known), no lamp is. None where it may be one.
std::optional<double> width_of_surface_m(std::span<const TrackRow> rows, const CameraSite& camera);

}  // namespace vildar
