#include "track/aim.h"

#include <algorithm>
#include <cmath>

#include "core/quantity.h"
#include "optics/camera.h"
#include "track/lamp.h"
#include "track/vehicle.h"

namespace vildar {
namespace {

constexpr double kUnsure_deg = 1.5;
constexpr double kWay_deg = 0.5;    // what steering and the road do to one vehicle's
constexpr double kLeast_deg = 1.0;  // hands that hold a camera drift

bool stands(const Site& site) {
  return !site.ego || (site.ego->trace.empty() && site.ego->speed_mps.mean == 0.0);
}

}  // namespace

Aim::Aim(const Site& site) : site_(site), focal_px_(Camera(*site.camera).focal_px()) {
  const CameraSite& camera = *site.camera;
  const double height_m = site.lamps.height_m ? site.lamps.height_m->mean : 0.68;
  const double separation_m = site.lamps.separation_m ? site.lamps.separation_m->mean : 1.25;
  constexpr double kHigh_m = 1.0;  // over the lamps: from lower down the middle hardly moves
  drop_per_separation_ = (camera.position_m[2].mean - height_m) / separation_m;
  if (!stands(site) || drop_per_separation_ * separation_m < kHigh_m) return;
  const double unsure_rad = radians_from_degrees(kUnsure_deg);
  learns_pitch_ = camera.pitch_rad.std > unsure_rad;
  learns_yaw_ = camera.yaw_rad.std > unsure_rad && site.road.kind == RoadKind::straight;
  told_sigma_px_ = focal_px_ * std::max(camera.pitch_rad.std, camera.yaw_rad.std);
}

std::optional<Site> Aim::learn(const Vehicles& vehicles, std::int64_t frame) {
  if (!learns_yaw_ && !learns_pitch_) return std::nullopt;
  for (const auto& vehicle : vehicles) {
    const Lamp *left = vehicle->left, *right = vehicle->right;
    if (left && right && left->seen_at(frame) && right->seen_at(frame) &&
        left->records.back().merged_px == 0.0)
      see(*left, *right);
  }
  return news();
}

void Aim::see(const Lamp& left, const Lamp& right) {
  const Eigen::Vector2d &left_px = left.records.back().at_px,
                        &right_px = right.records.back().at_px;
  const double width_px = (right_px - left_px).norm();
  const Eigen::Array2d middle_px = 0.5 * (left_px + right_px).array();
  Way& way = ways_[{left.id, right.id}];
  way.least_px = way.count > 0.0 ? std::min(way.least_px, width_px) : width_px;
  way.most_px = std::max(way.most_px, width_px);
  way.count += 1.0;
  way.width_px += width_px;
  way.width2_px2 += width_px * width_px;
  way.middle_px += middle_px;
  way.by_width_px2 += width_px * middle_px;
  way.square_px2 += middle_px.square();
}

std::optional<Aim::End> Aim::end_of(const Way& way) const {
  constexpr double kFewest = 12.0, kLeastWidth_px = 4.0, kGrown = 1.4;
  constexpr double kLeastLike = 0.5, kMostLike = 1.5;  // lorries' lamps are farther apart
  constexpr double kStraight_px = 3.0;                 // rms
  if (way.count < kFewest || way.least_px < kLeastWidth_px || way.most_px < kGrown * way.least_px)
    return std::nullopt;
  const double spread_px2 = way.width2_px2 - way.width_px * way.width_px / way.count;
  const Eigen::Array2d across = way.by_width_px2 - way.width_px * way.middle_px / way.count;
  const Eigen::Array2d slope = across / spread_px2;
  const double like = slope.y() / drop_per_separation_;
  if (!(like > kLeastLike && like < kMostLike)) return std::nullopt;
  const Eigen::Array2d left_px2 =
      (way.square_px2 - way.middle_px.square() / way.count - slope * across).max(0.0);
  const Eigen::Array2d rms_px = (left_px2 / (way.count - 2.0)).sqrt();
  if (!(rms_px < kStraight_px).all()) return std::nullopt;
  // Neighbouring frames are off alike.
  constexpr double kFramesAlike = 5.0, kLeastRms_px = 0.3;
  const double mean_px = way.width_px / way.count;
  const double lever = std::sqrt(kFramesAlike * (1.0 / way.count + mean_px * mean_px / spread_px2));
  const double floor_px = focal_px_ * radians_from_degrees(kWay_deg);
  const Eigen::Array2d sigma_px = (rms_px.max(kLeastRms_px) * lever).square();
  return End{(way.middle_px - slope * way.width_px) / way.count,
             (sigma_px + floor_px * floor_px).sqrt()};
}

std::optional<Site> Aim::news() {
  constexpr double kBetter = 0.7;
  Eigen::Array2d weights = Eigen::Array2d::Zero(), sum_px = Eigen::Array2d::Zero();
  for (const auto& [lamps, way] : ways_)
    if (const auto end = end_of(way)) {
      const Eigen::Array2d weight = end->sigma_px.square().inverse();
      weights += weight;
      sum_px += weight * end->at_px;
    }
  if (!(weights > 0.0).all()) return std::nullopt;
  const Eigen::Array2d sigma_px = weights.sqrt().inverse(), at_px = sum_px / weights;
  if (sigma_px.maxCoeff() > kBetter * told_sigma_px_) return std::nullopt;
  told_sigma_px_ = sigma_px.maxCoeff();
  CameraSite& camera = *site_.camera;
  const double least_rad = radians_from_degrees(kLeast_deg);
  if (learns_pitch_)
    camera.pitch_rad = {std::atan(at_px.y() / focal_px_),
                        std::max(least_rad, sigma_px.y() / focal_px_)};
  if (learns_yaw_)
    camera.yaw_rad = {std::atan(at_px.x() / focal_px_ * std::cos(camera.pitch_rad.mean)),
                      std::max(least_rad, sigma_px.x() / focal_px_)};
  constexpr double kEnough_deg = 0.4;
  if (told_sigma_px_ < focal_px_ * radians_from_degrees(kEnough_deg)) {
    learns_yaw_ = learns_pitch_ = false;
    ways_.clear();
  }
  return site_;
}

}  // namespace vildar
