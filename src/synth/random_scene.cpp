#include "synth/random_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "config/site_file.h"
#include "core/random.h"
#include "core/text.h"
#include "synth/random_site.h"

namespace vildar {
namespace {

constexpr std::array<std::pair<std::string_view, ScenePreset>, 7> kPresets{
    {{"straight", ScenePreset::straight},
     {"three-lanes", ScenePreset::three_lanes},
     {"curve", ScenePreset::curve},
     {"dashcam", ScenePreset::dashcam},
     {"photodiode", ScenePreset::photodiode},
     {"wet", ScenePreset::wet},
     {"survey", ScenePreset::survey}}};

constexpr double kDuration_s = 6.0;
constexpr double kAccelerationStd_mps2 = 0.4;

struct DrawnVehicle {
  std::size_t lane = 0;
  double speed_mps = 0.0, acceleration_mps2 = 0.0, along_m = 0.0;  ///< at t = 0
  double closing_mps = 0.0;  ///< speed_mps and that of the sensors

  double along_at_m(double time_s) const {
    return along_m - closing_mps * time_s - 0.5 * acceleration_mps2 * time_s * time_s;
  }
};

DrawnVehicle draw_vehicle(ScenePreset preset, const Site& site, Random& random) {
  DrawnVehicle vehicle;
  std::vector<std::size_t> oncoming;
  for (std::size_t i = 0; i < site.road.lanes.size(); ++i)
    if (site.road.lanes[i].direction == Direction::oncoming) oncoming.push_back(i);
  vehicle.lane = oncoming[std::min(
      oncoming.size() - 1,
      static_cast<std::size_t>(random.uniform() * static_cast<double>(oncoming.size())))];
  vehicle.speed_mps =
      preset == ScenePreset::curve ? random.uniform(8.0, 18.0) : random.uniform(8.0, 36.0);
  vehicle.acceleration_mps2 = random.normal(0.0, kAccelerationStd_mps2);
  vehicle.closing_mps = vehicle.speed_mps + (site.ego ? site.ego->speed_mps.mean : 0.0);
  // At half time it is where the sensors see it well.
  const double middle_m =
      preset == ScenePreset::dashcam ? random.uniform(30.0, 70.0) : random.uniform(15.0, 45.0);
  vehicle.along_m = middle_m - vehicle.along_at_m(0.5 * kDuration_s);
  return vehicle;
}

// Vehicles of one lane stay a length and a half apart.
bool collide(const DrawnVehicle& a, const DrawnVehicle& b) {
  if (a.lane != b.lane) return false;
  const double sign = a.along_m > b.along_m ? 1.0 : -1.0;
  for (double time_s = 0.0; time_s <= kDuration_s; time_s += 0.1)
    if (sign * (a.along_at_m(time_s) - b.along_at_m(time_s)) < 12.0) return true;
  return false;
}

int vehicle_count(ScenePreset preset, Random& random) {
  const auto between = [&](int low, int high) {
    return low + static_cast<int>(random.uniform() * (high - low + 1));
  };
  switch (preset) {
    case ScenePreset::three_lanes: return between(3, 5);
    case ScenePreset::straight:
    case ScenePreset::survey:
    case ScenePreset::wet: return between(1, 3);
    case ScenePreset::curve:
    case ScenePreset::dashcam: return between(1, 2);
    case ScenePreset::photodiode: return 1;
  }
  return 1;
}

double positive(const Uncertain& prior, Random& random) {
  double value = 0.0;
  while (!(value > 0.1)) value = random.normal(prior.mean, prior.std);
  return value;
}

std::string vehicle_line(const DrawnVehicle& vehicle, const Site& told, std::size_t index,
                         Random& random) {
  const LaneSite& lane = told.road.lanes[vehicle.lane];
  // A lane that is told without a spread: vehicles keep to its middle within a twelfth of its
  // width.
  const double aside_m =
      random.normal(0.0, lane.lateral_m.std > 0.0 ? lane.lateral_m.std : lane.width_m / 12.0);
  const bool motorcycle = random.uniform() < 0.1;
  std::string line = "  - {id: v" + std::to_string(index + 1) + ", lane: " + lane.id;
  const auto put = [&](const char* key, double value) {
    line += std::string(", ") + key + ": " + number_text(value);
  };
  line += motorcycle ? ", kind: motorcycle" : ", kind: car";
  put("speed_mps", vehicle.speed_mps);
  put("acceleration_mps2", vehicle.acceleration_mps2);
  put("along_at_zero_m", vehicle.along_m);
  put("lateral_offset_m", aside_m);
  put("lamp_height_m", positive(*told.lamps.height_m, random));
  const double separation_m = positive(*told.lamps.separation_m, random);
  put("lamp_separation_m", motorcycle ? 0.0 : separation_m);
  put("intensity_cd", 600.0 * std::exp(random.normal(0.0, 0.4)));
  put("power_ratio", std::pow(10.0, 0.1 * random.normal(0.0, told.channel->gain_db->std)));
  return line + "}\n";
}

std::string indented(const std::string& site_yaml) {
  std::string text;
  std::size_t from = site_yaml.find('\n') + 1;  // without the version line
  while (from < site_yaml.size()) {
    const std::size_t end = std::min(site_yaml.find('\n', from), site_yaml.size());
    text += "  " + site_yaml.substr(from, end - from) + "\n";
    from = end + 1;
  }
  return text;
}

}  // namespace

std::optional<ScenePreset> preset_of(std::string_view name) {
  for (const auto& [known, preset] : kPresets)
    if (known == name) return preset;
  return std::nullopt;
}

std::string preset_names() {
  std::string names;
  for (const auto& [name, preset] : kPresets)
    names += (names.empty() ? "" : ", ") + std::string(name);
  return names;
}

std::string random_scenario_yaml(ScenePreset preset, std::uint64_t seed, std::uint64_t index) {
  // Far-apart starts of one generator for every scene of every family.
  Random random(seed * 1'000'003ULL + index * 101ULL + static_cast<std::uint64_t>(preset));
  const Site told = told_site(preset, random);
  const Site truth = drawn_site(told, random);
  std::vector<DrawnVehicle> vehicles;
  const int wanted = vehicle_count(preset, random);
  constexpr int kMostTries = 200;
  for (int tries = 0; std::ssize(vehicles) < wanted && tries < kMostTries; ++tries) {
    const DrawnVehicle vehicle = draw_vehicle(preset, truth, random);
    if (std::none_of(vehicles.begin(), vehicles.end(),
                     [&](const DrawnVehicle& other) { return collide(vehicle, other); }))
      vehicles.push_back(vehicle);
  }

  std::string text =
      "# Random scene " + std::to_string(index) + " of seed " + std::to_string(seed) + ".\n";
  text += "duration_s: " + number_text(kDuration_s) +
          "\nframe_rate_hz: 25\nseed: " + std::to_string(seed * 1'000ULL + index) + "\n";
  if (preset == ScenePreset::wet) text += "wet_road: true\nweather: {rain_mm_per_h: 5}\n";
  text += "image: {road_cd_per_m2: 0.3}\n";
  if (truth.camera) text += "encoder: {codec: h264, crf: 23}\n";
  if (!truth.photodiodes.empty())
    text += "photodiode: {rate_hz: 1000, noise_w: 5.0e-10, ambient_w: 2.0e-8, digits: 5}\n";
  text += "site:\n" + indented(effective_site_yaml(truth)) + "told_site:\n" +
          indented(effective_site_yaml(told)) + "vehicles:\n";
  for (std::size_t i = 0; i < vehicles.size(); ++i)
    text += vehicle_line(vehicles[i], told, i, random);
  return text;
}

}  // namespace vildar
