#include "synth/scenario.h"

#include <cmath>
#include <set>

#include "config/site_file.h"
#include "optics/road.h"

namespace vildar {
namespace {

constexpr std::array<Choice<VehicleKind>, 3> kKindWords{{{"car", VehicleKind::car},
                                                         {"lorry", VehicleKind::lorry},
                                                         {"motorcycle", VehicleKind::motorcycle}}};
constexpr std::array<Choice<VehicleLamps>, 2> kLampWords{
    {{"head", VehicleLamps::head}, {"tail", VehicleLamps::tail}}};
constexpr std::array<Choice<ClipCodec>, 2> kCodecWords{
    {{"h264", ClipCodec::h264}, {"ffv1", ClipCodec::ffv1}}};

constexpr NumberRule kDuration_s{0.0, 3600.0, true, false};
constexpr NumberRule kFrameRate_hz{0.0, 1000.0, true, false};
constexpr NumberRule kSampleRate_hz{100.0, 100'000.0, false, false};
constexpr NumberRule kShare{0.0, 1.0, false, true};

// What a vehicle of its kind usually is; tail lamps shine a hundredth of what headlamps do.
VehicleScene usual(VehicleKind kind, VehicleLamps lamps) {
  VehicleScene vehicle;
  vehicle.kind = kind;
  vehicle.lamps = lamps;
  switch (kind) {
    case VehicleKind::car: break;
    case VehicleKind::lorry:
      vehicle.lamp_height_m = 0.9;
      vehicle.lamp_separation_m = 2.0;
      break;
    case VehicleKind::motorcycle:
      vehicle.lamp_height_m = 0.85;
      vehicle.lamp_separation_m = 0.0;
      break;
  }
  if (lamps == VehicleLamps::tail) {
    vehicle.intensity_cd = 8.0;
    vehicle.power_ratio = 0.01;
  }
  return vehicle;
}

// The length of the lane's path up to x; nothing where the lane never gets there.
std::optional<double> along_of_x(const RoadSite& road, double x_m, double lateral_m) {
  const double bend = bend_of(road);
  if (bend == 0.0 || x_m <= road.straight_m || !road.radius_m) return x_m;
  const double lane_radius_m = road.radius_m->mean - bend * lateral_m;
  const double sine = (x_m - road.straight_m) / lane_radius_m;
  if (!(sine < 1.0)) return std::nullopt;
  return road.straight_m + lane_radius_m * std::asin(sine);
}

void read_place(const YamlMap& map, const RoadSite& road, VehicleScene& vehicle) {
  if (map.has("along_at_zero_m")) {
    map.require("along_at_zero_m", vehicle.along_at_zero_m);
    map.refuse("range_at_zero_m", "is given beside along_at_zero_m", "keep one of the two");
    return;
  }
  double range_m = 0.0;
  map.require("range_at_zero_m", range_m);
  const double lateral_m =
      road.lanes[static_cast<std::size_t>(vehicle.lane)].lateral_m.mean + vehicle.lateral_offset_m;
  if (const auto along_m = along_of_x(road, range_m, lateral_m))
    vehicle.along_at_zero_m = *along_m;
  else
    map.problem("range_at_zero_m", "the lane's curve never reaches this x",
                "give the length along the lane as along_at_zero_m");
}

std::optional<VehicleScene> read_vehicle(const YamlMap& map, const RoadSite& road) {
  std::string id, lane;
  map.require("id", id);
  map.require("lane", lane);
  VehicleKind kind = VehicleKind::car;
  map.read("kind", kind, kKindWords);
  int lane_index = -1;
  std::string known;
  for (std::size_t i = 0; i < road.lanes.size(); ++i) {
    if (road.lanes[i].id == lane) lane_index = static_cast<int>(i);
    known += (known.empty() ? "" : ", ") + road.lanes[i].id;
  }
  const bool found = lane_index >= 0;
  if (!found && !lane.empty())
    map.problem("lane", "\"" + lane + "\" is not a lane of the site",
                known.empty() ? "give the site's road its lanes" : "use one of: " + known);
  VehicleLamps lamps = VehicleLamps::head;
  if (found && road.lanes[static_cast<std::size_t>(lane_index)].direction == Direction::receding)
    lamps = VehicleLamps::tail;
  map.read("lamps", lamps, kLampWords);

  VehicleScene vehicle = usual(kind, lamps);
  vehicle.id = id;
  vehicle.lane = lane_index;
  map.require("speed_mps", vehicle.speed_mps, kNotNegative);
  map.read("acceleration_mps2", vehicle.acceleration_mps2);
  map.read("lateral_offset_m", vehicle.lateral_offset_m);
  map.read("lamp_height_m", vehicle.lamp_height_m, kPositive);
  map.read("lamp_separation_m", vehicle.lamp_separation_m, kNotNegative);
  map.read("lamp_radius_m", vehicle.lamp_radius_m, kPositive);
  map.read("intensity_cd", vehicle.intensity_cd, kNotNegative);
  map.read("power_ratio", vehicle.power_ratio, kNotNegative);
  if (id.find_first_of(",\"\n\r") != std::string::npos)
    map.problem("id", "\"" + id + "\" would break the columns of the truth files",
                "use letters, digits, - and _");
  if (!found) {
    map.find("along_at_zero_m");
    map.find("range_at_zero_m");
    return std::nullopt;
  }
  const double bend = bend_of(road);
  const double lateral_m =
      road.lanes[static_cast<std::size_t>(lane_index)].lateral_m.mean + vehicle.lateral_offset_m;
  if (bend != 0.0 && road.radius_m && !(road.radius_m->mean - bend * lateral_m > 0.0)) {
    map.problem("lateral_offset_m", "puts the vehicle beyond the centre of the curve",
                "keep it within the road");
    return std::nullopt;
  }
  read_place(map, road, vehicle);
  return vehicle;
}

void read_image(const YamlMap& map, ImageScene& image) {
  map.read("full_well_e", image.full_well_e, kPositive);
  map.read("electrons_per_lux_s", image.electrons_per_lux_s, kPositive);
  map.read("read_noise_e", image.read_noise_e, kNotNegative);
  map.read("shot_noise", image.shot_noise);
  map.read("black_level_e", image.black_level_e, kNotNegative);
  map.read("core_sigma_px", image.core_sigma_px, NumberRule{0.5, 20.0});
  map.read("wing_share", image.wing_share, kShare);
  map.read("wing_scale_px", image.wing_scale_px, NumberRule{0.5, 20.0});
  map.read("wing_exponent", image.wing_exponent, NumberRule{2.05, 8.0});
  map.read("sky_cd_per_m2", image.sky_cd_per_m2, kNotNegative);
  map.read("road_cd_per_m2", image.road_cd_per_m2, kNotNegative);
}

void read_encoder(const YamlMap& map, EncoderScene& encoder) {
  map.read("codec", encoder.codec, kCodecWords);
  if (encoder.codec == ClipCodec::ffv1) {
    map.refuse("crf", "ffv1 is lossless", "remove it, or use codec h264");
    map.refuse("bitrate_bps", "ffv1 is lossless", "remove it, or use codec h264");
    return;
  }
  if (map.has("bitrate_bps"))
    map.refuse("crf", "is given beside bitrate_bps", "keep one of the two");
  else
    map.read("crf", encoder.crf, NumberRule{0.0, 51.0});
  map.read("bitrate_bps", encoder.bitrate_bps, NumberRule{10'000.0, 1e9});
}

void read_photodiode_scene(const YamlMap& map, PhotodiodeScene& scene) {
  map.read("rate_hz", scene.rate_hz, kSampleRate_hz);
  map.read("snr_db", scene.snr_db, NumberRule{-60.0, 200.0});
  if (scene.snr_db)
    map.refuse("noise_w", "is given beside snr_db", "keep one of the two");
  else
    map.read("noise_w", scene.noise_w, kNotNegative);
  map.read("ambient_w", scene.ambient_w, kNotNegative);
  map.read("digits", scene.digits, NumberRule{3.0, 17.0});
}

bool read_site_of(const YamlMap& root, Site& site) {
  const auto item = root.find_required("site");
  if (!item) return false;
  if (item->is_map()) {
    site = read_site(*item->map());
    return true;
  }
  std::filesystem::path file;
  if (!item->get(file)) return false;
  try {
    site = load_site(file);
    return true;
  } catch (const ConfigError& error) {
    for (const Problem& problem : error.problems()) root.add(problem);
    return false;
  }
}

void check_sensors(const YamlMap& root, const Scenario& scenario) {
  const Site& site = scenario.site;
  if (site.camera && !site.camera->exposure_s)
    root.problem("site", "camera.exposure_s is missing", "the renderer needs to know it");
  if (site.camera && scenario.encoder.codec == ClipCodec::h264 &&
      (site.camera->width_px % 2 != 0 || site.camera->height_px % 2 != 0))
    root.problem("site", "camera.image_size_px is odd, which h264 cannot hold",
                 "use an even size, or codec ffv1");
  if (site.photodiodes.empty()) return;
  const auto& channel = site.channel;
  if (!channel || !channel->beam.empty() || !channel->gain_db || !channel->path_loss_exponent)
    root.problem("site", "photodiodes need channel.gain_db and channel.path_loss_exponent",
                 "give the channel of the site as a power law");
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
  if (const auto map = root.map("image")) read_image(*map, scenario.image);
  if (const auto map = root.map("encoder")) read_encoder(*map, scenario.encoder);
  if (const auto map = root.map("photodiode")) read_photodiode_scene(*map, scenario.photodiode);
  const bool have_site = read_site_of(root, scenario.site);

  std::set<std::string> ids;
  const std::vector<YamlMap> vehicles = root.maps("vehicles");
  if (have_site) {
    for (const YamlMap& map : vehicles) {
      const auto vehicle = read_vehicle(map, scenario.site.road);
      if (!vehicle) continue;
      if (!vehicle->id.empty() && !ids.insert(vehicle->id).second)
        map.problem("id", "\"" + vehicle->id + "\" is the id of another vehicle too",
                    "give each vehicle its own");
      scenario.vehicles.push_back(*vehicle);
    }
    check_sensors(root, scenario);
  }
  for (const YamlMap& map : root.maps("street_lamps")) {
    StreetLampScene lamp;
    map.require("position_m", lamp.position_m);
    map.require("intensity_cd", lamp.intensity_cd, kNotNegative);
    map.read("radius_m", lamp.radius_m, kPositive);
    scenario.street_lamps.push_back(lamp);
  }
  reader.finish();
  return scenario;
}

}  // namespace vildar
