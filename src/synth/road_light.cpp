#include "synth/road_light.h"

#include <algorithm>
#include <cmath>

#include "optics/lamp_beam.h"
#include "optics/road_surface.h"
#include "synth/ego.h"

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

RoadLight::RoadLight(GroundMap map, const Eigen::Vector3d& camera_m)
    : map_(std::move(map)), camera_m_(camera_m) {
  light_.resize(static_cast<std::size_t>(map_.columns()) * static_cast<std::size_t>(map_.rows()));
}

void RoadLight::update(const Scenario& scenario, const std::vector<VehicleState>& states,
                       double time_s) {
  static const LampBeam kUsual{LowBeam{}};
  struct Source {
    const LampBeam* beam;
    int lamps;
    Eigen::Vector3d lamp_m;
    Eigen::Vector2d ahead;
    double pitch_rad;
  };
  std::vector<Source> sources;
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
  dark_ = sources.empty();
  const RoadSurface& surface = road_surface(scenario.wet_road ? RoadTable::c2w3 : RoadTable::r3);
  for (const Source& source : sources) {
    const double heading_rad = std::atan2(source.ahead.y(), source.ahead.x());
    std::size_t place = 0;
    for (int row = 0; row < map_.rows(); ++row)
      for (int column = 0; column < map_.columns(); ++column, ++place) {
        const GroundMap::Point& point = map_.at(column, row);
        if (!point.ground) continue;
        const Eigen::Vector2d point_m(point.x_m, point.y_m);
        const Eigen::Vector2d way_m = point_m - source.lamp_m.head<2>();
        const double ahead_m = way_m.dot(source.ahead);
        if (!(ahead_m > 0.5 && ahead_m < kFarthest_m)) continue;
        const Eigen::Vector3d ground_m(point_m.x(), point_m.y(), 0.0);
        light_[place] +=
            static_cast<float>(surface.brdf_per_sr((source.lamp_m - ground_m).normalized(),
                                                   (camera_m_ - ground_m).normalized()) *
                               ground_illuminance_lx(*source.beam, source.lamps, source.lamp_m,
                                                     heading_rad, source.pitch_rad, point_m));
      }
  }
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
