#pragma once

#include <functional>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <vector>

#include <Eigen/Geometry>

#include "core/quantity.h"
#include "core/random.h"
#include "optics/camera.h"
#include "track/tracker.h"

namespace vildar::scene {

/// A vehicle of the made-up scene: place of its lamps over time, on a straight road.
struct Car {
  double x_m = 80.0, y_m = -4.0;  ///< at t = 0
  double speed_mps = -15.0;       ///< along x, over the ground; negative comes nearer
  LampKind kind = LampKind::headlamp;
  double separation_m = 1.25, height_m = 0.68;
  bool single = false;
  double power = 1.0;        ///< of each lamp, of a headlamp's
  double left_power = 1.0;   ///< of the left lamp beside the right one's
  double cr = 0.0;           ///< colour of the rim
  double turns_red_s = 1e9;  ///< from then on a dim red light
  std::vector<std::pair<double, double>> hidden_s;
  double left_hidden_from_s = 1e9, left_hidden_to_s = 1e9;  ///< that lamp alone
  double stops_at_s = 1e9, starts_again_s = 1e9;

  double place_m(double t_s) const {
    double driven_s = std::min(t_s, stops_at_s);
    if (t_s > starts_again_s) driven_s += t_s - starts_again_s;
    return x_m + speed_mps * driven_s;
  }
  bool hidden(double t_s) const {
    for (const auto& [from_s, to_s] : hidden_s)
      if (t_s >= from_s && t_s < to_s) return true;
    return false;
  }
};

struct Scene {
  Site site;
  std::optional<Site> told;  ///< what the tracker is told, where that is not the truth
  std::vector<Car> cars;
  std::vector<Eigen::Vector3d> street_lamps;  ///< in the world
  double frame_rate_hz = 25.0, duration_s = 5.0;
  double noise_px = 0.15, miss_share = 0.02, clutter_per_frame = 0.0, shake_px = 0.0;
  std::function<Eigen::Vector3d(double)> turned_rad;  ///< CameraTurn::rotation_rad at a time
  bool wet = false;                                   ///< images on the road of all lamps
  double image_heights = 2.0;  ///< how far below its lamp an image stands; 2: a mirror
  double resolution_px = 4.0;  ///< lights nearer than this are one blob
  std::uint64_t seed = 20260310;
};

inline Site site_of(double height_m, double pitch_deg, double focal_px, int width_px,
                    int height_px) {
  Site site;
  CameraSite camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.focal_px = {focal_px, focal_px};
  camera.principal_px = {0.5 * (width_px - 1), 0.5 * (height_px - 1)};
  camera.position_m = {Uncertain{0.0, 0.0}, Uncertain{0.0, 0.0}, Uncertain{height_m, 0.0}};
  camera.pitch_rad.mean = radians_from_degrees(pitch_deg);
  site.camera = camera;
  return site;
}

/// What the tracker made of the scene.
struct Outcome {
  std::vector<VehicleTrack> tracks;
  TrackCounts counts;
  std::vector<int> frames_seen;           ///< of each car: frames in which it left a blob
  std::vector<std::map<int, int>> votes;  ///< of each track: car -> lamps taken from it; -1 other
  std::map<LampKind, int> kinds_of_street_blobs, kinds_of_mirror_blobs;
  std::vector<Eigen::Vector2d> shakes_px;        ///< of each frame
  std::vector<std::optional<CameraTurn>> turns;  ///< the same, as told after the last

  /// The car that all lamps of a track belong to; nothing where there are several.
  std::optional<int> car_of(std::size_t track) const {
    if (votes[track].size() != 1 || votes[track].begin()->first < 0) return std::nullopt;
    return votes[track].begin()->first;
  }
  int tracks_of(int car) const {
    int n = 0;
    for (std::size_t i = 0; i < tracks.size(); ++i) n += car_of(i) == car;
    return n;
  }
  double recall(int car) const {
    std::set<std::int64_t> frames;
    for (std::size_t i = 0; i < tracks.size(); ++i)
      if (votes[i].count(car))
        for (const VehicleSighting& sighting : tracks[i].sightings) frames.insert(sighting.frame);
    return static_cast<double>(frames.size()) / frames_seen[car];
  }
};

constexpr int kSeveral = -4;

struct Light {
  Eigen::Vector2d at_px;
  double flux, radius_px;
  LampKind kind;
  double cr;
  int owner;  ///< car, or -1 street lamp, -2 mirror image, -3 clutter, kSeveral
};

inline std::vector<Light> lights_at(const Scene& scene, const Camera& camera, double t_s) {
  std::vector<Light> lights;
  const double ego_m = scene.site.ego ? scene.site.ego->speed_mps.mean * t_s : 0.0;
  const double camera_height_m = scene.site.camera->position_m[2].mean;
  const auto shine = [&](Eigen::Vector3d at_m, double power, LampKind kind, double cr, int owner) {
    at_m.x() -= ego_m;
    if (at_m.x() < 2.5) return;
    for (const bool mirror : {false, true}) {
      if (mirror && !scene.wet) continue;
      if (mirror) at_m.z() *= 1.0 - scene.image_heights;
      const auto pixel = camera.project(at_m);
      if (!pixel || pixel->x() < 0.0 || pixel->y() < 0.0 ||
          pixel->x() > scene.site.camera->width_px - 1 ||
          pixel->y() > scene.site.camera->height_px - 1)
        continue;
      const double distance_m = std::hypot(at_m.x(), at_m.y(), at_m.z() - camera_height_m);
      lights.push_back({*pixel, power * (mirror ? 0.15 : 1.0) * 4e5 / (distance_m * distance_m),
                        1.5 + 0.08 * camera.focal_px() / distance_m, kind, cr,
                        mirror ? -2 : owner});
    }
  };
  for (std::size_t c = 0; c < scene.cars.size(); ++c) {
    const Car& car = scene.cars[c];
    if (car.hidden(t_s)) continue;
    const double power = car.power * (car.kind == LampKind::taillamp ? 0.3 : 1.0);
    const bool red = t_s >= car.turns_red_s;
    for (const double side : {-0.5, 0.5}) {
      if (side > 0.0 && t_s >= car.left_hidden_from_s && t_s < car.left_hidden_to_s) continue;
      const double y_m = car.y_m + (car.single ? 0.0 : side * car.separation_m);
      shine({car.place_m(t_s), y_m, car.height_m}, power * (side > 0.0 ? car.left_power : 1.0),
            red ? LampKind::other : car.kind, red ? 0.12 : car.cr, static_cast<int>(c));
      if (car.single) break;
    }
  }
  for (const Eigen::Vector3d& lamp : scene.street_lamps)
    shine(lamp, 2.0, LampKind::headlamp, 0.0, -1);
  return lights;
}

/// Lights nearer to each other than the resolution are seen as one, at their common middle.
inline std::vector<Light> merged(std::vector<Light> lights, double resolution_px) {
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < lights.size() && !changed; ++i)
      for (std::size_t j = i + 1; j < lights.size() && !changed; ++j) {
        const double apart_px = (lights[i].at_px - lights[j].at_px).norm();
        if (apart_px > resolution_px) continue;
        const double sum = lights[i].flux + lights[j].flux;
        if (lights[j].flux > lights[i].flux) lights[i].kind = lights[j].kind;
        if (lights[j].owner != lights[i].owner) lights[i].owner = kSeveral;
        lights[i].at_px =
            (lights[i].at_px * lights[i].flux + lights[j].at_px * lights[j].flux) / sum;
        lights[i].flux = sum;
        lights[i].radius_px += 0.5 * apart_px;
        lights.erase(lights.begin() + static_cast<std::ptrdiff_t>(j));
        changed = true;
      }
  }
  return lights;
}

inline Outcome run(const Scene& scene, TrackOptions options = {}) {
  const Camera camera(*scene.site.camera);
  Tracker tracker(options, scene.told.value_or(scene.site));
  Random random(scene.seed);
  Outcome outcome;
  outcome.frames_seen.assign(scene.cars.size(), 0);
  std::map<std::int64_t, std::vector<std::pair<Eigen::Vector2d, int>>> owners;
  const auto keep = [&](std::vector<VehicleTrack> ended) {
    for (VehicleTrack& track : ended) outcome.tracks.push_back(std::move(track));
  };
  const int frames = static_cast<int>(scene.duration_s * scene.frame_rate_hz);
  for (int k = 0; k < frames; ++k) {
    const double t_s = k / scene.frame_rate_hz;
    BlobFrame frame;
    frame.frame = k;
    frame.time = time_from_seconds<CameraTime>(t_s);
    std::vector<Light> lights = merged(lights_at(scene, camera, t_s), scene.resolution_px);
    for (double n = scene.clutter_per_frame; random.uniform() < n; n -= 1.0)
      lights.push_back({{random.uniform(0.0, scene.site.camera->width_px - 1.0),
                         random.uniform(0.0, scene.site.camera->height_px - 1.0)},
                        random.uniform(20.0, 300.0),
                        1.5,
                        LampKind::headlamp,
                        0.0,
                        -3});
    if (scene.turned_rad)
      for (Light& light : lights) {
        const Eigen::Vector3d rotation_rad = scene.turned_rad(t_s);
        const Eigen::Vector3d ray =
            Eigen::AngleAxisd(-rotation_rad.norm(), rotation_rad.normalized()) *
            camera.normalized_from_pixel(light.at_px)->homogeneous();
        light.at_px = *camera.pixel_from_normalized(ray.hnormalized());
      }
    const Eigen::Vector2d shake_px(random.normal(0.0, scene.shake_px),
                                   random.normal(0.0, scene.shake_px));
    outcome.shakes_px.push_back(shake_px);
    std::set<int> seen;
    std::vector<int> owner_of_blob;
    for (const Light& light : lights) {
      if (random.uniform() < scene.miss_share) continue;
      Blob blob;
      blob.id = static_cast<int>(frame.blobs.size());
      blob.centre_px =
          light.at_px + shake_px +
          Eigen::Vector2d(random.normal(0.0, scene.noise_px), random.normal(0.0, scene.noise_px));
      blob.centre_sigma_px.setConstant(scene.noise_px);
      blob.flux = light.flux * std::exp(random.normal(0.0, 0.05));
      blob.flux_sigma = 0.05 * light.flux;
      blob.area_px = static_cast<int>(kPi * light.radius_px * light.radius_px);
      blob.spread_px.setConstant(0.5 * light.radius_px);
      blob.box = {static_cast<int>(blob.centre_px.x() - light.radius_px),
                  static_cast<int>(blob.centre_px.y() - light.radius_px),
                  static_cast<int>(blob.centre_px.x() + light.radius_px),
                  static_cast<int>(blob.centre_px.y() + light.radius_px)};
      blob.kind = light.kind;
      blob.cr = light.cr;
      blob.cb = -0.02;  // a colour camera sees lamps a little warm
      frame.blobs.push_back(blob);
      owner_of_blob.push_back(light.owner);
      owners[k].emplace_back(blob.centre_px, light.owner);
      if (light.owner >= 0) seen.insert(light.owner);
    }
    for (const int car : seen) ++outcome.frames_seen[car];
    keep(tracker.update(frame));
    for (std::size_t b = 0; b < frame.blobs.size(); ++b) {
      if (owner_of_blob[b] == -1) ++outcome.kinds_of_street_blobs[frame.blobs[b].kind];
      if (owner_of_blob[b] == -2) ++outcome.kinds_of_mirror_blobs[frame.blobs[b].kind];
    }
  }
  std::vector<std::int64_t> numbers(static_cast<std::size_t>(frames));
  std::iota(numbers.begin(), numbers.end(), 0);
  outcome.turns = tracker.turns_in(numbers);
  keep(tracker.finish());
  outcome.counts = tracker.counts();
  for (const VehicleTrack& track : outcome.tracks) {
    std::map<int, int> votes;
    for (const VehicleSighting& sighting : track.sightings)
      for (const auto* lamp : {&sighting.left, &sighting.right}) {
        if (!*lamp) continue;
        for (const auto& [centre_px, owner] : owners[sighting.frame])
          if (centre_px == (*lamp)->centre_px && owner != kSeveral) ++votes[owner];
      }
    outcome.votes.push_back(votes);
  }
  return outcome;
}

}  // namespace vildar::scene
