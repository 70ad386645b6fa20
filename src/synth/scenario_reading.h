#pragma once

#include <optional>

#include "config/yaml_reader.h"
#include "synth/scenario.h"

namespace vildar {

/// Parts of a scenario file. Problems go to the reader of the maps.
struct VehicleSetting {
  const Site& site;
  TrafficSide side = TrafficSide::right;
};
std::optional<VehicleScene> read_vehicle(const YamlMap& map, const VehicleSetting& setting);

/// Sine of a lamp on the mains: `flicker` (depth) and `flicker_phase` (cycles) of the map.
Waveform read_mains_flicker(const YamlMap& map, double mains_hz);

SignScene read_sign(const YamlMap& map);
void read_image(const YamlMap& map, ImageScene& image);
void read_frame_times(const YamlMap& map, FrameTimesScene& times);
void read_encoder(const YamlMap& map, EncoderScene& encoder);
void read_photodiode_scene(const YamlMap& map, PhotodiodeScene& scene);
void read_weather(const YamlMap& map, double& extinction_per_m);

}  // namespace vildar
