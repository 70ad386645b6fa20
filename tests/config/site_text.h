#pragma once

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "config/site_file.h"
#include "core/quantity.h"

namespace vildar {

inline constexpr double kDegree = kPi / 180.0;

/// The example of the contract, section 2, as it stands there.
inline constexpr std::string_view kContractSite = R"(version: 1
camera:                       # optional: photodiode-only sites have none
  image_size_px: [1920, 1080]
  focal_px: [1400.0, 1400.0]
  focal_std_px: 14.0
  principal_px: [959.5, 539.5]
  distortion: {model: brown, coefficients: [0, 0, 0, 0, 0]}   # k1 k2 p1 p2 k3
  position_m: [0.0, 0.0, 5.0] # in the road frame
  yaw_deg: 0.0
  pitch_deg: -4.0
  roll_deg: 0.0
  exposure_s: 0.002
  rolling_shutter_s: 0.0      # first row to last row
  response: {kind: srgb}      # linear | gamma (exponent) | srgb | bt709 | table (256 values)
photodiodes:                  # optional: camera-only sites have none
- id: pd0
  position_m: [0.0, 0.0, 5.0]
  yaw_deg: 0.0
  pitch_deg: 0.0
  half_field_of_view_deg: 70
  area_m2: 1.0e-4
  gain_ratio: {mean: 1.0, std: 0.002}      # relative to the first photodiode of the list
  responsivity_a_per_w: 0.45  # with transimpedance_v_per_a, turns volts into watts
  transimpedance_v_per_a: 1.0e6
  time_offset_s: {mean: 0.0, std: 0.02}    # one for all photodiodes that share a trace file
mains_hz: 50                  # street lamps flicker at twice this
road:
  kind: straight              # straight | curved
  straight_m: 0.0             # curved only
  radius_m: 40.0              # curved only
  turn: left                  # curved only
  lanes:
    - {id: near, lateral_m: -4.0, width_m: 3.5, direction: oncoming}
    - {id: far,  lateral_m: -7.5, width_m: 3.5, direction: receding}
  speed_limit_mps: 13.9
lamps:                        # what vehicles are like, for those not measured one by one
  height_m: {mean: 0.68, std: 0.08}
  separation_m: {mean: 1.25, std: 0.12}
  tail_height_m: {mean: 0.85, std: 0.15}
  tail_separation_m: 1.2
channel:
  gain_db: {mean: -49.32, std: 3.0}      # K_dB: power at D = 1 m over the lamp's total power
  path_loss_exponent: {mean: 1.21, std: 0.05}
  lamp_power_w: 1.0                      # optical, of the whole vehicle
ego:                          # dashcam only
  speed_mps: 0.0              # or trace
)";

/// `text` with its one occurrence of `from` replaced; throws where there is not exactly one.
inline std::string with(std::string_view text, std::string_view from, std::string_view to) {
  std::string out(text);
  const auto at = out.find(from);
  if (at == std::string::npos || out.find(from, at + 1) != std::string::npos)
    throw std::logic_error("not exactly once in the text: " + std::string(from));
  return out.replace(at, from.size(), to);
}

/// Line of the first occurrence of `part`, 1-based.
inline int line_of(std::string_view text, std::string_view part) {
  const auto at = text.find(part);
  if (at == std::string_view::npos) throw std::logic_error("not in the text: " + std::string(part));
  int line = 1;
  for (const char c : text.substr(0, at)) line += c == '\n' ? 1 : 0;
  return line;
}

/// What is wrong with a site file; nothing where it loads.
inline std::vector<Problem> problems_of(const std::filesystem::path& file) {
  try {
    load_site(file);
  } catch (const ConfigError& error) {
    return error.problems();
  }
  return {};
}

}  // namespace vildar
