#include "synth/random_site.h"

#include <algorithm>

#include "core/quantity.h"

namespace vildar {
namespace {

constexpr Uncertain degrees(double mean_deg, double std_deg) {
  return {radians_from_degrees(mean_deg), radians_from_degrees(std_deg)};
}

// A mast of 5 m at the roadside; `blur` scales what is not known of its pose.
CameraSite mast_camera(double blur) {
  CameraSite camera;
  camera.width_px = 960;
  camera.height_px = 540;
  camera.focal_px = {800.0, 800.0};
  camera.principal_px = {479.5, 269.5};
  camera.distortion = DistortionModel::brown;
  camera.distortion_coefficients = {-0.08, 0.02, 0.0, 0.0, 0.0};
  camera.position_m = {Uncertain{0.0, 0.0}, Uncertain{0.0, 0.0}, Uncertain{5.0, 0.03 * blur}};
  camera.yaw_rad = degrees(-8.0, 0.1 * blur);
  camera.pitch_rad = degrees(-7.0, 0.1 * blur);
  camera.roll_rad = degrees(0.0, 0.2 * blur);
  camera.exposure_s = 0.001;
  camera.rolling_shutter_s = 0.015;
  return camera;
}

PhotodiodeSite diode_at(const char* id, double x_m) {
  PhotodiodeSite diode;
  diode.id = id;
  diode.position_m[0].mean = x_m;
  diode.position_m[2].mean = 5.0;
  diode.yaw_rad = radians_from_degrees(-8.0);
  diode.pitch_rad = radians_from_degrees(-7.0);
  diode.half_field_of_view_rad = radians_from_degrees(60.0);
  diode.area_m2 = 1e-4;
  diode.time_offset_s = {0.0, 0.005};
  return diode;
}

LaneSite lane(const char* id, double lateral_m, Direction direction) {
  return {id, {lateral_m, 0.0}, 3.5, direction};
}

double drawn(const Uncertain& quantity, Random& random) {
  return quantity.std > 0.0 ? random.normal(quantity.mean, quantity.std) : quantity.mean;
}
void settle(Uncertain& quantity, Random& random) { quantity = {drawn(quantity, random), 0.0}; }

}  // namespace

Site told_site(ScenePreset preset, Random& random) {
  const bool survey = preset == ScenePreset::survey;
  Site site;
  site.lamps.height_m = survey ? Uncertain{0.65, 0.02} : Uncertain{0.68, 0.08};
  site.lamps.separation_m = survey ? Uncertain{1.30, 0.03} : Uncertain{1.25, 0.12};
  ChannelSite channel;
  channel.gain_db = {-42.4, survey ? 0.1 : 1.0};
  channel.path_loss_exponent = {2.0, survey ? 0.005 : 0.02};
  site.channel = channel;
  site.road.speed_limit_mps = 22.2;
  site.road.lanes = {lane("near", -3.0, Direction::oncoming),
                     lane("middle", -6.5, Direction::oncoming)};
  if (preset == ScenePreset::three_lanes)
    site.road.lanes.push_back(lane("far", -10.0, Direction::oncoming));
  if (preset == ScenePreset::photodiode) {
    site.photodiodes = {diode_at("pd0", 0.0), diode_at("pd1", 2.0)};
    site.photodiodes[1].gain_ratio = {1.0, 0.002};
    return site;
  }
  site.camera = mast_camera(survey ? 0.05 : 1.0);
  if (preset != ScenePreset::dashcam) site.photodiodes = {diode_at("pd0", 0.0)};
  if (preset == ScenePreset::curve) {
    site.road.kind = RoadKind::curved;
    site.road.turn = random.uniform() < 0.5 ? Turn::left : Turn::right;
    site.road.straight_m = {15.0, 1.5};
    const double radius_m = random.uniform(80.0, 200.0);
    site.road.radius_m = Uncertain{radius_m, 0.01 * radius_m};
  }
  if (preset == ScenePreset::dashcam) {
    site.camera->position_m[2] = {1.3, 0.02};
    site.camera->yaw_rad = degrees(0.0, 0.3);
    site.camera->pitch_rad = degrees(-2.0, 0.1);
    site.road.lanes = {lane("own", 0.0, Direction::receding),
                       lane("other", 3.5, Direction::oncoming)};
    site.ego = EgoSite{{random.uniform(10.0, 25.0), 0.15}, {}, {}};
  }
  return site;
}

Site drawn_site(const Site& told, Random& random) {
  Site site = told;
  if (site.camera) {
    for (Uncertain& place : site.camera->position_m) settle(place, random);
    for (Uncertain* angle :
         {&site.camera->yaw_rad, &site.camera->pitch_rad, &site.camera->roll_rad})
      settle(*angle, random);
  }
  for (PhotodiodeSite& diode : site.photodiodes) {
    for (Uncertain& place : diode.position_m) settle(place, random);
    settle(diode.gain_ratio, random);
  }
  // One clock for all photodiodes of a trace.
  if (!site.photodiodes.empty()) {
    settle(site.photodiodes.front().time_offset_s, random);
    for (PhotodiodeSite& diode : site.photodiodes)
      diode.time_offset_s = site.photodiodes.front().time_offset_s;
  }
  if (site.road.radius_m) settle(*site.road.radius_m, random);
  if (site.channel && site.channel->path_loss_exponent)
    settle(*site.channel->path_loss_exponent, random);
  if (site.ego) settle(site.ego->speed_mps, random);
  if (site.road.straight_m.std > 0.0) settle(site.road.straight_m, random);
  return site;
}

}  // namespace vildar
