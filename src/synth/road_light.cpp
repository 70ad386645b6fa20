#include "synth/road_light.h"

#include <algorithm>
#include <cmath>

#include "optics/atmosphere.h"
#include "optics/lamp_beam.h"
#include "optics/road_surface.h"
#include "synth/ego.h"
#include "synth/light.h"
#include "synth/row_time.h"

namespace vildar {
namespace {

constexpr double kFarthest_m = 70.0;

}  // namespace

double ground_illuminance_lx(const LampBeam& beam, int lamps, const Eigen::Vector3d& lamp_m,
                             double heading_rad, double pitch_rad, const Eigen::Vector2d& point_m) {
  const Eigen::Vector3d way_m(point_m.x() - lamp_m.x(), point_m.y() - lamp_m.y(), -lamp_m.z());
  const double distance2_m2 = way_m.squaredNorm();
  const double cosine = lamp_m.z() / std::sqrt(distance2_m2);
  return lamps * beam.intensity_cd(vehicle_from_road(way_m, heading_rad, pitch_rad)) * cosine /
         distance2_m2;
}

double street_illuminance_lx(double intensity_cd, const Eigen::Vector3d& lamp_m,
                             const Eigen::Vector2d& point_m) {
  const double distance2_m2 = (lamp_m.head<2>() - point_m).squaredNorm() + lamp_m.z() * lamp_m.z();
  return intensity_cd * lamp_m.z() / (distance2_m2 * std::sqrt(distance2_m2));
}

struct RoadLight::Headlamps {
  const LampBeam* beam = nullptr;
  int lamps = 2;
  Eigen::Vector3d lamp_m = Eigen::Vector3d::Zero();
  Eigen::Vector2d ahead = Eigen::Vector2d::UnitX();
  double pitch_rad = 0.0;
};

namespace {

const RoadSurface& surface_of(const Scenario& scenario) {
  return road_surface(scenario.wet_road ? RoadTable::c2w3 : RoadTable::r3);
}

// What the air leaves of light from a lamp to the ground and on to the camera.
double air_share(const Scenario& scenario, const Eigen::Vector3d& lamp_m,
                 const Eigen::Vector3d& ground_m, const Eigen::Vector3d& camera_m) {
  if (scenario.extinction_per_m == 0.0) return 1.0;
  return transmittance(scenario.extinction_per_m,
                       Metres((lamp_m - ground_m).norm() + (camera_m - ground_m).norm()));
}

}  // namespace

RoadLight::RoadLight(GroundMap map, const Eigen::Vector3d& camera_m)
    : map_(std::move(map)), camera_m_(camera_m) {
  light_.resize(static_cast<std::size_t>(map_.columns()) * static_cast<std::size_t>(map_.rows()));
}

void RoadLight::add_headlamps(const Scenario& scenario, const Headlamps& source) {
  const RoadSurface& surface = surface_of(scenario);
  const double heading_rad = std::atan2(source.ahead.y(), source.ahead.x());
  std::size_t place = 0;
  for (int row = 0; row < map_.rows(); ++row)
    for (int column = 0; column < map_.columns(); ++column, ++place) {
      const GroundMap::Point& point = map_.at(column, row);
      if (!point.ground) continue;
      const Eigen::Vector2d point_m(point.x_m, point.y_m);
      const double ahead_m = (point_m - source.lamp_m.head<2>()).dot(source.ahead);
      if (!(ahead_m > 0.5 && ahead_m < kFarthest_m)) continue;
      const Eigen::Vector3d ground_m(point_m.x(), point_m.y(), 0.0);
      light_[place] +=
          static_cast<float>(surface.brdf_per_sr((source.lamp_m - ground_m).normalized(),
                                                 (camera_m_ - ground_m).normalized()) *
                             ground_illuminance_lx(*source.beam, source.lamps, source.lamp_m,
                                                   heading_rad, source.pitch_rad, point_m) *
                             air_share(scenario, source.lamp_m, ground_m, camera_m_));
    }
}

std::vector<float> RoadLight::street_light(const Scenario& scenario, std::size_t lamp,
                                           double time_s) const {
  const RoadSurface& surface = surface_of(scenario);
  Emitter emitter;
  emitter.lamp = lamp;
  const Eigen::Vector3d lamp_m = emitter_position_m(scenario, emitter, time_s);
  std::vector<float> light(light_.size(), 0.0F);
  if (!(lamp_m.z() > 0.0)) return light;
  std::size_t place = 0;
  for (int row = 0; row < map_.rows(); ++row)
    for (int column = 0; column < map_.columns(); ++column, ++place) {
      const GroundMap::Point& point = map_.at(column, row);
      if (!point.ground) continue;
      const Eigen::Vector3d ground_m(point.x_m, point.y_m, 0.0);
      light[place] =
          static_cast<float>(surface.brdf_per_sr((lamp_m - ground_m).normalized(),
                                                 (camera_m_ - ground_m).normalized()) *
                             street_illuminance_lx(scenario.street_lamps[lamp].intensity_cd, lamp_m,
                                                   ground_m.head<2>()) *
                             air_share(scenario, lamp_m, ground_m, camera_m_));
    }
  return light;
}

void RoadLight::add_street_lamps(const Scenario& scenario, double time_s) {
  const CameraSite& site = *scenario.site.camera;
  const double half_s = 0.5 * site.exposure_s.value();
  const bool still = !scenario.site.ego;
  const auto columns = static_cast<std::size_t>(map_.columns());
  for (std::size_t lamp = 0; lamp < scenario.street_lamps.size(); ++lamp) {
    if (still && still_street_light_.size() <= lamp)
      still_street_light_.push_back(street_light(scenario, lamp, time_s));
    const std::vector<float> moving =
        still ? std::vector<float>() : street_light(scenario, lamp, time_s);
    const std::vector<float>& light = still ? still_street_light_[lamp] : moving;
    for (int row = 0; row < map_.rows(); ++row) {
      const double row_s = time_of_row_s(site, time_s, row * map_.step_px());
      const auto level = static_cast<float>(
          scenario.street_lamps[lamp].waveform.mean(row_s - half_s, row_s + half_s));
      const std::size_t start = static_cast<std::size_t>(row) * columns;
      for (std::size_t i = start; i < start + columns; ++i) light_[i] += level * light[i];
    }
  }
}

void RoadLight::update(const Scenario& scenario, const std::vector<VehicleState>& states,
                       double time_s) {
  static const LampBeam kUsual{LowBeam{}};
  std::vector<Headlamps> sources;
  for (std::size_t i = 0; i < states.size(); ++i) {
    const VehicleScene& vehicle = scenario.vehicles[i];
    if (vehicle.lamps != VehicleLamps::head) continue;
    sources.push_back({vehicle.beam ? &*vehicle.beam : &kUsual,
                       vehicle.lamp_separation_m == 0.0 ? 1 : 2,
                       {states[i].place_m.x(), states[i].place_m.y(), vehicle.lamp_height_m},
                       states[i].forward,
                       pitch_rad_at(vehicle, time_s)});
  }
  if (scenario.image.own_lamps)
    sources.push_back({&kUsual, 2, {0.5, 0.0, 0.65}, Eigen::Vector2d::UnitX(), 0.0});
  if (!dark_) std::fill(light_.begin(), light_.end(), 0.0F);
  dark_ = sources.empty() && scenario.street_lamps.empty();
  for (const Headlamps& source : sources) add_headlamps(scenario, source);
  add_street_lamps(scenario, time_s);
}

void RoadLight::row(int v, int width, float* cd_per_m2) const {
  const int step = map_.step_px();
  const auto columns = static_cast<std::size_t>(map_.columns());
  const float* above = &light_[static_cast<std::size_t>(v / step) * columns];
  const float* below = above + columns;
  const float down = static_cast<float>(v % step) / static_cast<float>(step);
  for (int i = 0, u = 0; u < width; ++i) {
    const float left = above[i] + down * (below[i] - above[i]);
    const float right = above[i + 1] + down * (below[i + 1] - above[i + 1]);
    const float slope = (right - left) / static_cast<float>(step);
    for (int k = 0; k < step && u < width; ++k, ++u)
      cd_per_m2[u] = left + static_cast<float>(k) * slope;
  }
}

}  // namespace vildar
