#include "synth/scenario.h"

#include <cmath>
#include <set>

#include "config/site_file.h"
#include "core/text.h"
#include "synth/motion.h"
#include "synth/scenario_reading.h"

namespace vildar {
namespace {

constexpr std::array<Choice<TrafficSide>, 2> kSideWords{
    {{"right", TrafficSide::right}, {"left", TrafficSide::left}}};

constexpr NumberRule kDuration_s{0.0, 3600.0, true, false};
constexpr NumberRule kFrameRate_hz{0.0, 1000.0, true, false};

std::optional<Site> read_site_of(const YamlMap& root, const YamlItem& item,
                                 std::vector<std::filesystem::path>& files) {
  if (item.is_map()) return read_site(*item.map());
  std::filesystem::path file;
  if (!item.get(file)) return std::nullopt;
  files.push_back(file);
  try {
    return load_site(file);
  } catch (const ConfigError& error) {
    for (const Problem& problem : error.problems()) root.add(problem);
    return std::nullopt;
  }
}

void check_photodiodes(const YamlMap& root, const Scenario& scenario) {
  const Site& site = scenario.site;
  const PhotodiodeScene& scene = scenario.photodiode;
  if (site.photodiodes.empty()) return;
  const auto& channel = site.channel;
  if (!channel || (channel->beam.empty() && (!channel->gain_db || !channel->path_loss_exponent)))
    root.problem("site", "photodiodes need channel.gain_db and channel.path_loss_exponent",
                 "give the channel of the site as a power law, or a beam");
  for (std::size_t i = 0; i < site.photodiodes.size(); ++i) {
    const PhotodiodeSite& diode = site.photodiodes[i];
    const auto missing = [&](bool there, const char* key, const std::string& why) {
      if (!there)
        root.problem("site", "photodiodes[" + std::to_string(i) + "]." + key + " is missing",
                     why + " needs it");
    };
    if (channel && !channel->beam.empty()) missing(diode.area_m2.has_value(), "area_m2", "a beam");
    const bool amperes = scene.quantity != PowerQuantity::power_w;
    const bool volts = amperes && scene.quantity != PowerQuantity::current_a;
    if (scene.shot_noise || scene.temperature_k || amperes)
      missing(diode.responsivity_a_per_w.has_value(), "responsivity_a_per_w",
              amperes ? "photodiode.quantity" : "the noise of the current");
    if (scene.temperature_k || volts)
      missing(diode.transimpedance_v_per_a.has_value(), "transimpedance_v_per_a",
              volts ? "photodiode.quantity" : "photodiode.temperature_k");
    if (scene.quantity == PowerQuantity::counts)
      missing(diode.volts_per_count.has_value(), "volts_per_count", "the quantity counts");
  }
}

void check_camera(const YamlMap& root, const Scenario& scenario) {
  const Site& site = scenario.site;
  if (!site.camera) return;
  if (!site.camera->exposure_s)
    root.problem("site", "camera.exposure_s is missing", "the renderer needs to know it");
  if (scenario.encoder.codec != ClipCodec::ffv1 &&
      (site.camera->width_px % 2 != 0 || site.camera->height_px % 2 != 0))
    root.problem("site", "camera.image_size_px is odd, which h264, h265 and mjpeg cannot hold here",
                 "use an even size, or codec ffv1");
}

// No sensor may be driven through.
void check_ways(const YamlMap& map, const Scenario& scenario, const VehicleScene& vehicle) {
  std::vector<std::pair<std::string, Eigen::Vector3d>> sensors;
  const auto place = [](const std::array<Uncertain, 3>& m) {
    return Eigen::Vector3d(m[0].mean, m[1].mean, m[2].mean);
  };
  if (scenario.site.camera)
    sensors.emplace_back("the camera", place(scenario.site.camera->position_m));
  for (const PhotodiodeSite& diode : scenario.site.photodiodes)
    sensors.emplace_back("photodiode " + diode.id, place(diode.position_m));
  constexpr double kStep_s = 0.01;
  Scenario alone = scenario;
  alone.vehicles = {vehicle};
  for (double time_s = 0.0; time_s < scenario.duration_s; time_s += kStep_s) {
    const VehicleState state = seen_state_at(alone, 0, time_s);
    for (const auto& [name, place_m] : sensors)
      if (body_holds(vehicle, state, place_m)) {
        map.problem("", name + " is inside this vehicle at t = " + fixed_text(time_s, 2) + " s",
                    "move the sensor off its lane, or the vehicle (lateral_offset_m)");
        return;
      }
  }
}

}  // namespace

Scenario load_scenario(const std::filesystem::path& file) {
  const YamlReader reader(file);
  const YamlMap root = reader.root();
  Scenario scenario;
  scenario.file = file;
  root.require("duration_s", scenario.duration_s, kDuration_s);
  root.read("frame_rate_hz", scenario.frame_rate_hz, kFrameRate_hz);
  root.read("seed", scenario.seed);
  root.read("wet_road", scenario.wet_road);
  TrafficSide side = TrafficSide::right;
  root.read("traffic_side", side, kSideWords);
  if (const auto map = root.map("weather")) read_weather(*map, scenario.extinction_per_m);
  if (const auto map = root.map("image")) read_image(*map, scenario.image);
  if (const auto map = root.map("frame_times")) read_frame_times(*map, scenario.frame_times);
  if (const auto map = root.map("encoder")) read_encoder(*map, scenario.encoder);
  if (const auto map = root.map("photodiode")) read_photodiode_scene(*map, scenario.photodiode);
  if (const auto map = root.map("shake")) {
    map->read_degrees("yaw_std_deg", scenario.shake.yaw_std_rad, NumberRule{0.0, 5.0});
    map->read_degrees("pitch_std_deg", scenario.shake.pitch_std_rad, NumberRule{0.0, 5.0});
    map->read("frequency_hz", scenario.shake.frequency_hz, kPositive);
  }
  std::optional<Site> site;
  const std::size_t problems_before = reader.problem_count();
  if (const auto item = root.find_required("site"))
    site = read_site_of(root, *item, scenario.site_files);
  // What could not be read is not missing as well.
  const bool site_is_sound = reader.problem_count() == problems_before;
  if (const auto item = root.find("told_site"))
    scenario.told_site = read_site_of(root, *item, scenario.site_files);

  std::set<std::string> ids;
  if (!site) root.find("vehicles");  // what they may say depends on the site
  if (site) {
    scenario.site = *site;
    for (const YamlMap& map : root.maps("vehicles")) {
      const auto vehicle = read_vehicle(map, {scenario.site, side});
      if (!vehicle) continue;
      if (!vehicle->id.empty() && !ids.insert(vehicle->id).second)
        map.problem("id", "\"" + vehicle->id + "\" is the id of another vehicle too",
                    "give each vehicle its own");
      check_ways(map, scenario, *vehicle);
      scenario.vehicles.push_back(*vehicle);
    }
    if (site_is_sound) {
      check_camera(root, scenario);
      check_photodiodes(root, scenario);
    }
  }
  for (const YamlMap& map : root.maps("street_lamps")) {
    StreetLampScene lamp;
    map.require("position_m", lamp.position_m);
    map.require("intensity_cd", lamp.intensity_cd, kNotNegative);
    map.read("radius_m", lamp.radius_m, kPositive);
    lamp.waveform = read_mains_flicker(map, scenario.site.mains_hz);
    scenario.street_lamps.push_back(lamp);
  }
  for (const YamlMap& map : root.maps("signs")) scenario.signs.push_back(read_sign(map));
  reader.finish();
  return scenario;
}

}  // namespace vildar
