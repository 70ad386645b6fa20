#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace vildar {

/// Families of random scenes. `survey` is `straight` with every fact of the site known to the
/// accuracy of a land survey; `photodiode` has two photodiodes and no camera.
enum class ScenePreset { straight, three_lanes, curve, dashcam, photodiode, wet, survey };

/// "straight", "three-lanes", "curve", "dashcam", "photodiode", "wet" or "survey".
std::optional<ScenePreset> preset_of(std::string_view name);
/// All names, for messages.
std::string preset_names();

/// Scenario `index` of a family, as the text of a scenario file. What its `told_site` states as a
/// prior is drawn from that prior: pose, offsets and gains once, height and separation of the
/// lamps, place in the lane and channel gain for every vehicle. Equal arguments, equal text.
std::string random_scenario_yaml(ScenePreset preset, std::uint64_t seed, std::uint64_t index);

}  // namespace vildar
