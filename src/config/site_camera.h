#pragma once

#include <array>

#include "config/yaml_reader.h"
#include "types/site.h"

namespace vildar {

/// What a pitch angle may be, in degrees.
inline constexpr NumberRule kPitch_deg{-90.0, 90.0, false, false};

/// Reads `position_m`, which must be within a kilometre of the mast and 100 m of the road's height.
bool require_position(const YamlMap& map, std::array<Uncertain, 3>& position_m);

/// The `camera` map of a site file; problems go to the reader of the map.
CameraSite read_camera(const YamlMap& map);

/// Where a camera that stands looks, as far as its map leaves that out: at the middle of the lanes
/// 40 m ahead, with a std of 4 degrees of pitch and 5 of yaw, or a quarter of what there is between
/// those 20 and 100 m ahead, as from a building.
void suppose_aim(const YamlMap& map, const RoadSite& road, CameraSite& camera);

}  // namespace vildar
