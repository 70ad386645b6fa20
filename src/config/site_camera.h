#pragma once

#include "config/yaml_reader.h"
#include "types/site.h"

namespace vildar {

/// What a pitch angle may be, in degrees.
inline constexpr NumberRule kPitch_deg{-90.0, 90.0, false, false};

/// The `camera` map of a site file; problems go to the reader of the map.
CameraSite read_camera(const YamlMap& map);

}  // namespace vildar
