#include "synth/scenario_reading.h"

#include <cmath>

#include "optics/channel.h"
#include "optics/ies_file.h"
#include "optics/road.h"

namespace vildar {
namespace {

constexpr std::array<Choice<VehicleKind>, 3> kKindWords{{{"car", VehicleKind::car},
                                                         {"lorry", VehicleKind::lorry},
                                                         {"motorcycle", VehicleKind::motorcycle}}};
constexpr std::array<Choice<VehicleLamps>, 2> kLampWords{
    {{"head", VehicleLamps::head}, {"tail", VehicleLamps::tail}}};

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
  if (bend == 0.0 || x_m <= road.straight_m.mean || !road.radius_m) return x_m;
  const double lane_radius_m = road.radius_m->mean - bend * lateral_m;
  const double sine = (x_m - road.straight_m.mean) / lane_radius_m;
  if (!(sine < 1.0)) return std::nullopt;
  return road.straight_m.mean + lane_radius_m * std::asin(sine);
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

int lane_index(const YamlMap& map, const std::string& key, const RoadSite& road) {
  std::string wanted;
  map.require(key, wanted);
  std::string known;
  for (std::size_t i = 0; i < road.lanes.size(); ++i) {
    if (road.lanes[i].id == wanted) return static_cast<int>(i);
    known += (known.empty() ? "" : ", ") + road.lanes[i].id;
  }
  if (!wanted.empty())
    map.problem(key, "\"" + wanted + "\" is not a lane of the site",
                known.empty() ? "give the site's road its lanes" : "use one of: " + known);
  return -1;
}

void read_changes(const YamlMap& map, const RoadSite& road, VehicleScene& vehicle) {
  double last_s = 0.0;
  for (const YamlMap& item : map.maps("speed_changes")) {
    SpeedChange change;
    item.require("from_s", change.from_s, kPositive);
    item.require("acceleration_mps2", change.acceleration_mps2);
    if (change.from_s <= last_s && change.from_s > 0.0)
      item.problem("from_s", "does not come after the change before it", "list them in order");
    last_s = change.from_s;
    vehicle.speed_changes.push_back(change);
  }
  int lane = vehicle.lane;
  for (const YamlMap& item : map.maps("lane_changes")) {
    LaneChange change;
    item.require("from_s", change.from_s);
    item.read("duration_s", change.duration_s, kPositive);
    change.to_lane = lane_index(item, "to", road);
    if (change.to_lane < 0 || lane < 0) continue;
    const auto lateral_m = [&](int index) {
      return road.lanes[static_cast<std::size_t>(index)].lateral_m.mean;
    };
    change.shift_m = lateral_m(change.to_lane) - lateral_m(lane);
    lane = change.to_lane;
    vehicle.lane_changes.push_back(change);
  }
  if (const auto pitch = map.map("pitching")) {
    pitch->read_degrees("amplitude_deg", vehicle.pitch.amplitude_rad, NumberRule{0.0, 10.0});
    pitch->read("frequency_hz", vehicle.pitch.frequency_hz, kPositive);
    pitch->read_degrees("phase_deg", vehicle.pitch.phase_rad);
  }
}

// The beam of the vehicle, or else that of the site's channel.
std::optional<LampBeam> read_beam(const YamlMap& map, const VehicleSetting& setting,
                                  const VehicleScene& vehicle) {
  const bool own = map.has("beam");
  std::string word = setting.site.channel ? setting.site.channel->beam : "";
  std::filesystem::path file = word;
  if (const auto item = map.find("beam")) {
    if (!item->get(word)) return std::nullopt;
    item->get(file);
  }
  LampAim aim;
  double scale = 1.0, half_power_rad = 0.0;
  const NumberRule aim_deg{-45.0, 45.0};
  map.read_degrees("aim_yaw_deg", aim.yaw_rad, aim_deg);
  map.read_degrees("aim_pitch_deg", aim.pitch_rad, aim_deg);
  if (word == "lambertian")
    map.require_degrees("half_power_angle_deg", half_power_rad, NumberRule{0.0, 90.0, true, true});
  else
    map.read("beam_scale", scale, kNotNegative);
  if (word.empty() || (!own && vehicle.lamps == VehicleLamps::tail)) return std::nullopt;
  if (word == "lambertian") {
    if (!(half_power_rad > 0.0)) return std::nullopt;
    return LampBeam(LambertianBeam{vehicle.intensity_cd, lambertian_order(Radians(half_power_rad))},
                    aim);
  }
  map.refuse("intensity_cd", "is given beside a beam that has intensities of its own",
             "remove it, or use beam_scale");
  if (word == "low_beam") return LampBeam(LowBeam{setting.side}, aim, scale);
  if (word == "high_beam") return LampBeam(HighBeam{}, aim, scale);
  if (word == "daytime_running") return LampBeam(kDaytimeRunningLamp, aim, scale);
  if (word == "tail_lamp") return LampBeam(kTailLamp, aim, scale);
  try {
    return LampBeam(TableBeam{read_ies(file).table, TypeCAxis::ahead}, aim, scale);
  } catch (const InputError& error) {
    map.problem(own ? "beam" : "", std::string("cannot be used: ") + error.what(),
                "use low_beam, high_beam, daytime_running, tail_lamp, lambertian or an LM-63 file");
  }
  return std::nullopt;
}

Waveform read_pulses(const YamlMap& map) {
  const auto pulses = map.map("pulses");
  if (!pulses) return {};
  double frequency_hz = 0.0, duty = 0.0, phase = 0.0;
  const bool whole = pulses->require("frequency_hz", frequency_hz, kPositive) &
                     pulses->require("duty", duty, NumberRule{0.0, 1.0, true, false});
  pulses->read("phase", phase, NumberRule{0.0, 1.0});
  return whole ? Waveform::pulses(frequency_hz, duty, phase) : Waveform();
}

}  // namespace

std::optional<VehicleScene> read_vehicle(const YamlMap& map, const VehicleSetting& setting) {
  const RoadSite& road = setting.site.road;
  std::string id;
  map.require("id", id);
  VehicleKind kind = VehicleKind::car;
  map.read("kind", kind, kKindWords);
  const int lane = lane_index(map, "lane", road);
  const bool found = lane >= 0;
  VehicleLamps lamps = VehicleLamps::head;
  if (found && road.lanes[static_cast<std::size_t>(lane)].direction == Direction::receding)
    lamps = VehicleLamps::tail;
  map.read("lamps", lamps, kLampWords);

  VehicleScene vehicle = usual(kind, lamps);
  vehicle.id = id;
  vehicle.lane = lane;
  map.require("speed_mps", vehicle.speed_mps, kNotNegative);
  map.read("acceleration_mps2", vehicle.acceleration_mps2);
  map.read("lateral_offset_m", vehicle.lateral_offset_m);
  map.read("lamp_height_m", vehicle.lamp_height_m, kPositive);
  map.read("lamp_separation_m", vehicle.lamp_separation_m, kNotNegative);
  map.read("lamp_radius_m", vehicle.lamp_radius_m, kPositive);
  map.read("intensity_cd", vehicle.intensity_cd, kNotNegative);
  map.read("power_ratio", vehicle.power_ratio, kNotNegative);
  vehicle.waveform = read_pulses(map);
  read_changes(map, road, vehicle);
  vehicle.beam = read_beam(map, setting, vehicle);
  if (id.find_first_of(",\"\n\r") != std::string::npos)
    map.problem("id", "\"" + id + "\" would break the columns of the truth files",
                "use letters, digits, - and _");
  if (!found) {
    map.find("along_at_zero_m");
    map.find("range_at_zero_m");
    return std::nullopt;
  }
  const double bend = bend_of(road);
  double lateral_m =
      road.lanes[static_cast<std::size_t>(lane)].lateral_m.mean + vehicle.lateral_offset_m;
  std::vector<double> laterals_m{lateral_m};
  for (const LaneChange& change : vehicle.lane_changes)
    laterals_m.push_back(lateral_m += change.shift_m);
  for (const double place_m : laterals_m)
    if (bend != 0.0 && road.radius_m && !(road.radius_m->mean - bend * place_m > 0.0)) {
      map.problem("lateral_offset_m", "puts the vehicle beyond the centre of the curve",
                  "keep it within the road");
      return std::nullopt;
    }
  read_place(map, road, vehicle);
  return vehicle;
}

}  // namespace vildar
