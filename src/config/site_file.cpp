#include "config/site_file.h"

#include <algorithm>
#include <cctype>
#include <set>
#include <system_error>

#include "config/ego_trace.h"
#include "config/lamp_classes.h"
#include "config/site_camera.h"
#include "config/site_words.h"
#include "core/text.h"
#include "optics/road.h"

namespace vildar {
namespace {

namespace fs = std::filesystem;

// Wider than any tube before a photodiode leaves, and than a right angle in radians.
constexpr NumberRule kHalfField_deg{2.0, 90.0, false, false, "degrees"};
constexpr NumberRule kArea_m2{0.0, 0.1, true, false, "square metres"};
constexpr NumberRule kMains_hz{10.0, 1000.0, false, false};
constexpr NumberRule kHalfPower_deg{0.0, 90.0, true, true};
// Of all that drives on roads, motorcycles with two headlamps and work lamps of tractors included.
constexpr NumberRule kLampHeight_m{0.1, 4.0, false, false, "metres"};
constexpr NumberRule kLampSeparation_m{0.1, 3.0, false, false, "metres"};
constexpr NumberRule kLateral_m{-300.0, 300.0, false, false, "metres"};
constexpr NumberRule kLaneWidth_m{0.0, 30.0, true, false, "metres"};

PhotodiodeSite read_photodiode(const YamlMap& map, bool alone, bool first) {
  constexpr Uncertain kSameType{1.0, 0.05};  // parts of 1 to 5 %
  PhotodiodeSite diode;
  if (!first && !map.has("gain_ratio")) {
    diode.gain_ratio = kSameType;
    diode.gain_ratio_told = false;
  }
  if (alone) {
    diode.id = "pd0";
    map.read("id", diode.id);
  } else {
    map.require("id", diode.id);
  }
  const auto is_plain = [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.';
  };
  if (!std::all_of(diode.id.begin(), diode.id.end(), is_plain))
    map.problem("id", "\"" + diode.id + "\" cannot begin the name of a column",
                "use letters, digits, and the signs _ - .");
  require_position(map, diode.position_m);
  map.read_degrees("yaw_deg", diode.yaw_rad);
  map.read_degrees("pitch_deg", diode.pitch_rad, kPitch_deg);
  map.read_degrees("half_field_of_view_deg", diode.half_field_of_view_rad, kHalfField_deg);
  map.read("area_m2", diode.area_m2, kArea_m2);
  map.read("gain_ratio", diode.gain_ratio, kPositive);
  if (first && diode.gain_ratio.mean != 1.0)
    map.problem(
        "gain_ratio", "is to the first photodiode of the list, which this one is",
        "leave it out here, divide the others' by it, and add 10 log10 of it to channel.gain_db");
  map.read("responsivity_a_per_w", diode.responsivity_a_per_w, kPositive);
  map.read("transimpedance_v_per_a", diode.transimpedance_v_per_a, kPositive);
  map.read("volts_per_count", diode.volts_per_count, kPositive);
  map.read("full_scale_v", diode.full_scale_v, kPositive);
  if (map.has("volts_per_count") && map.has("full_scale_v"))
    map.problem("full_scale_v", "stands beside volts_per_count", "keep one of the two");
  map.read("time_offset_s", diode.time_offset_s);
  return diode;
}

/// Notes ids that an earlier element of the list already has.
template <class Element>
void check_ids(const std::vector<YamlMap>& maps, const std::vector<Element>& elements) {
  std::set<std::string> seen;
  for (std::size_t i = 0; i < maps.size(); ++i)
    if (!elements[i].id.empty() && !seen.insert(elements[i].id).second)
      maps[i].problem("id", "\"" + elements[i].id + "\" is taken by an earlier element",
                      "give each an id of its own");
}

std::vector<PhotodiodeSite> read_photodiodes(const YamlMap& map) {
  std::vector<YamlMap> maps;
  if (map.has("photodiode") && map.has("photodiodes")) {
    map.find("photodiodes");
    map.refuse("photodiode", "stands beside photodiodes", "move it into the list photodiodes");
    return {};
  }
  if (const auto single = map.map("photodiode")) maps.push_back(*single);
  for (YamlMap& element : map.maps("photodiodes")) maps.push_back(std::move(element));
  std::vector<PhotodiodeSite> diodes;
  for (const YamlMap& element : maps)
    diodes.push_back(read_photodiode(element, maps.size() == 1, diodes.empty()));
  check_ids(maps, diodes);
  return diodes;
}

LaneSite read_lane(const YamlMap& map) {
  LaneSite lane;
  map.require("id", lane.id);
  map.require("lateral_m", lane.lateral_m, kLateral_m);
  map.read("width_m", lane.width_m, kLaneWidth_m);
  map.require("direction", lane.direction, kDirectionWords);
  return lane;
}

// A vehicle that has its sensor with it is on the bend all along.
RoadSite read_road(const YamlMap& map, bool from_vehicle) {
  RoadSite road;
  const bool knows_kind = map.has("kind");
  map.read("kind", road.kind, kRoadWords);
  map.read("straight_m", road.straight_m, kNotNegative);
  if (road.kind == RoadKind::curved) {
    if (!from_vehicle && !map.has("straight_m"))
      map.problem(
          "straight_m", "is missing",
          "give the metres along the road from the sensor to where the bend begins, 0 where "
          "it is on the bend");
    map.require("radius_m", road.radius_m, kPositive);
    map.require("turn", road.turn, kTurnWords);
  } else {
    map.read("radius_m", road.radius_m, kPositive);
    map.read("turn", road.turn, kTurnWords);
    if (!knows_kind && (map.has("radius_m") || map.has("turn")))
      map.problem("kind", "is missing beside keys of a curved road",
                  "write kind: curved, or kind: straight to leave them unused");
  }
  const std::vector<YamlMap> lanes = map.maps("lanes");
  for (const YamlMap& element : lanes) {
    const LaneSite lane = read_lane(element);
    const double bend = bend_of(road);
    if (road.radius_m && bend != 0.0 && !(road.radius_m->mean - bend * lane.lateral_m.mean > 0.0))
      element.problem(
          "lateral_m",
          number_text(lane.lateral_m.mean) + " lies at or beyond the centre of the bend",
          "must be nearer to the line y = 0 than radius_m (" + number_text(road.radius_m->mean) +
              ") on the inner side");
    road.lanes.push_back(lane);
  }
  check_ids(lanes, road.lanes);
  map.read("speed_limit_mps", road.speed_limit_mps, kPositive);
  return road;
}

LampClass read_lamp_class(const YamlMap& map) {
  LampClass kind;
  map.require("id", kind.id);
  map.read("share", kind.share, kPositive);
  map.require("height_m", kind.height_m, kLampHeight_m);
  map.read("separation_m", kind.separation_m, kLampSeparation_m);
  map.read("tail_height_m", kind.tail_height_m, kLampHeight_m);
  map.read("tail_separation_m", kind.tail_separation_m, kLampSeparation_m);
  return kind;
}

LampsSite read_lamps(const YamlMap& map) {
  LampsSite lamps;
  if (map.has("classes")) {
    for (const std::string_view name : {"height_m", "separation_m"})
      map.refuse(name, "stands beside classes", "keep either the classes or the one population");
    const std::vector<YamlMap> maps = map.maps("classes");
    for (const YamlMap& element : maps) lamps.classes.push_back(read_lamp_class(element));
    check_ids(maps, lamps.classes);
    if (!lamps.classes.empty())
      pool_classes(lamps);
    else if (maps.empty())
      map.problem("classes", "names no class", "give at least one, or height_m and separation_m");
  } else {
    map.read("height_m", lamps.height_m, kLampHeight_m);
    map.read("separation_m", lamps.separation_m, kLampSeparation_m);
  }
  map.read("tail_height_m", lamps.tail_height_m, kLampHeight_m);
  map.read("tail_separation_m", lamps.tail_separation_m, kLampSeparation_m);
  return lamps;
}

/// A beam is a word, or an LM-63 file that exists.
void read_beam(const YamlMap& map, ChannelSite& channel) {
  const auto item = map.find("beam");
  if (!item || !item->get(channel.beam)) return;
  for (const std::string_view name : {"gain_db", "path_loss_exponent", "half_power_angle_deg"})
    map.refuse(name, "stands beside beam",
               "keep either beam or the power law (gain_db, path_loss_exponent)");
  constexpr std::array<std::string_view, 2> kBeams{"low_beam", "high_beam"};
  if (std::find(kBeams.begin(), kBeams.end(), channel.beam) != kBeams.end()) return;
  fs::path file;
  item->get(file);
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension != ".ies") {
    const std::string_view near = nearest_name(channel.beam, kBeams);
    item->problem("\"" + channel.beam.substr(0, 60) + "\" is not a beam",
                  (near.empty() ? "" : "did you mean \"" + std::string(near) + "\"? ") +
                      std::string("must be low_beam, high_beam, or an LM-63 file (.ies)"));
    return;
  }
  std::error_code error;
  if (!fs::is_regular_file(file, error))
    item->problem("the file " + file.string() + " does not exist",
                  "check the path; it is relative to this YAML file");
  channel.beam = file.string();
}

ChannelSite read_channel(const YamlMap& map) {
  ChannelSite channel;
  read_beam(map, channel);
  if (channel.beam.empty()) {
    map.read("gain_db", channel.gain_db);
    map.read("path_loss_exponent", channel.path_loss_exponent, kPositive);
    map.read_degrees("half_power_angle_deg", channel.half_power_angle_rad, kHalfPower_deg);
  }
  map.read("luminous_efficacy_lm_per_w", channel.luminous_efficacy_lm_per_w, kPositive);
  map.read("lamp_power_w", channel.lamp_power_w, kPositive);
  channel.lamp_power_told = map.has("lamp_power_w");
  return channel;
}

EgoSite read_ego(const YamlMap& map) {
  EgoSite ego;
  map.read("speed_mps", ego.speed_mps, kNotNegative);
  const auto trace = map.find("trace");
  if (trace && map.has("speed_mps"))
    map.problem("trace", "stands beside speed_mps", "keep one of the two");
  if (trace)
    map.read("speed_std_mps", ego.speed_mps.std, kNotNegative);
  else
    map.refuse("speed_std_mps", "belongs to a trace", "write speed_mps: {mean: ..., std: ...}");
  if (!trace && !map.has("speed_mps"))
    map.problem("", "has neither speed_mps nor trace", "give one of the two");
  if (trace && trace->get(ego.trace_path)) {
    std::vector<Problem> problems;
    ego.trace = read_ego_trace(ego.trace_path, problems);
    if (!problems.empty())
      trace->problem("the trace cannot be used: " + to_string(problems.front()), "mend that file");
    for (std::size_t i = 1; i < problems.size(); ++i) map.add(problems[i]);
  }
  return ego;
}

std::optional<LearnedFrom> read_learned(const YamlMap& learned, std::string_view command) {
  const auto map = learned.map(command);
  if (!map) return std::nullopt;
  LearnedFrom from;
  for (const YamlMap& element : map->maps("quantities")) {
    LearnedFrom::Quantity& quantity = from.quantities.emplace_back();
    element.require("key", quantity.key);
    element.require("stated", quantity.stated);
    element.require("learned", quantity.learned);
  }
  const auto clips = map->find("clips");
  if (const auto items = clips ? clips->items() : std::nullopt)
    for (const YamlItem& item : *items) item.get(from.clips.emplace_back());
  return from;
}

}  // namespace

Site read_site(const YamlMap& map) {
  Site site;
  site.file = map.file();
  const auto camera = map.map("camera");
  if (camera) site.camera = read_camera(*camera);
  site.photodiodes = read_photodiodes(map);
  if (!map.has("camera") && !map.has("photodiodes") && !map.has("photodiode"))
    map.problem("", "has neither a camera nor a photodiode", "add `camera:` or `photodiodes:`");
  map.read("mains_hz", site.mains_hz, kMains_hz);
  if (const auto road = map.map("road")) site.road = read_road(*road, map.has("ego"));
  if (const auto lamps = map.map("lamps")) site.lamps = read_lamps(*lamps);
  if (const auto channel = map.map("channel")) site.channel = read_channel(*channel);
  if (const auto ego = map.map("ego")) site.ego = read_ego(*ego);
  if (const auto learned = map.map("learned"))
    site.learned = {read_learned(*learned, "mount"), read_learned(*learned, "photodiode")};
  if (camera && (!site.ego || site.ego->stands())) suppose_aim(*camera, site.road, *site.camera);
  if (site.channel && !site.channel->beam.empty())
    for (const PhotodiodeSite& diode : site.photodiodes)
      if (!diode.area_m2)
        map.problem(map.has("photodiodes") ? "photodiodes" : "photodiode",
                    diode.id + " has no area_m2, which channel.beam needs",
                    "give its sensitive area in square metres");
  return site;
}

Site load_site(const fs::path& file) {
  const YamlReader reader(file);
  int version = 0;
  reader.root().require("version", version, NumberRule{1.0, 1.0, false, false});
  Site site = read_site(reader.root());
  reader.finish();
  return site;
}

void check_site_fits_clip(const Site& site, int width_px, int height_px) {
  const auto text = [](int width, int height) {
    return std::to_string(width) + " x " + std::to_string(height);
  };
  const std::string clip = text(width_px, height_px);
  if (!site.camera)
    throw ConfigError(
        {{site.file.string(), 0, "camera", "is missing, but a clip of " + clip + " px was given",
          "add the camera that recorded it, or leave the clip out"}});
  const CameraSite& camera = *site.camera;
  if (camera.width_px == width_px && camera.height_px == height_px) return;
  const bool turned = camera.width_px == height_px && camera.height_px == width_px;
  throw ConfigError(
      {{site.file.string(), 0, "camera.image_size_px",
        "is " + text(camera.width_px, camera.height_px) + " px, the clip has " + clip + " px",
        turned ? "describe the camera for the upright image, or turn the clip"
               : "use the site file of this camera mode, or scale image_size_px, "
                 "focal_px and principal_px together"}});
}

}  // namespace vildar
