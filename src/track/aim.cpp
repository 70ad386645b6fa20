#include "track/aim.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/quantity.h"
#include "optics/camera.h"
#include "track/lamp.h"
#include "track/vehicle.h"

namespace vildar {
namespace {

constexpr double kUnsure_deg = 1.5;
constexpr double kWay_deg = 0.5;    // what steering and the road do to one vehicle's
constexpr double kLeast_deg = 1.0;  // hands that hold a camera drift

// A way's end weighed with what the site says.
Uncertain with_stated(const Uncertain& stated, const Uncertain& found) {
  const double stated_weight = 1.0 / (stated.std * stated.std);
  const double weight = 1.0 / (found.std * found.std);
  return {(stated_weight * stated.mean + weight * found.mean) / (stated_weight + weight),
          std::max(radians_from_degrees(kLeast_deg), 1.0 / std::sqrt(stated_weight + weight))};
}

}  // namespace

Aim::Aim(const Site& site)
    : site_(site), stated_(*site.camera), focal_px_(Camera(*site.camera).focal_px()) {
  const CameraSite& camera = *site.camera;
  const double height_m = site.lamps.height_m ? site.lamps.height_m->mean : 0.68;
  const double separation_m = site.lamps.separation_m ? site.lamps.separation_m->mean : 1.25;
  constexpr double kHigh_m = 1.0;  // over the lamps: from lower down the middle hardly moves
  drop_per_separation_ = (camera.position_m[2].mean - height_m) / separation_m;
  if ((site.ego && !site.ego->stands()) || drop_per_separation_ * separation_m < kHigh_m) return;
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
      see(*left, *right, frame);
  }
  constexpr std::int64_t kForgotten = 300;  // frames
  std::erase_if(ways_, [&](const auto& way) {
    return frame - way.second.last_frame > kForgotten && !end_of(way.second);
  });
  return news();
}

void Aim::see(const Lamp& left, const Lamp& right, std::int64_t frame) {
  const Eigen::Vector2d &left_px = left.records.back().at_px,
                        &right_px = right.records.back().at_px;
  const double width_px = (right_px - left_px).norm();
  const Eigen::Array2d middle_px = 0.5 * (left_px + right_px).array();
  Way& way = ways_[{left.id, right.id}];
  way.least_px = way.count > 0.0 ? std::min(way.least_px, width_px) : width_px;
  way.most_px = std::max(way.most_px, width_px);
  way.last_frame = frame;
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
  // On a bend the middle leaves the line sideways.
  if (!(rms_px.y() < kStraight_px) || (learns_yaw_ && !(rms_px.x() < kStraight_px)))
    return std::nullopt;
  // Neighbouring frames are off alike.
  constexpr double kFramesAlike = 5.0, kLeastRms_px = 0.3;
  const double mean_px = way.width_px / way.count;
  const double lever = std::sqrt(kFramesAlike * (1.0 / way.count + mean_px * mean_px / spread_px2));
  const double floor_px = focal_px_ * radians_from_degrees(kWay_deg);
  const Eigen::Array2d sigma_px = (rms_px.max(kLeastRms_px) * lever).square();
  return End{(way.middle_px - slope * way.width_px) / way.count,
             (sigma_px + floor_px * floor_px).sqrt(), 1};
}

// Of the ways that agree; of three or more the one farthest from the others may be of no vehicle.
std::optional<Aim::End> Aim::common_end() const {
  constexpr double kAgree = 3.0;  // sigmas
  std::vector<End> ends;
  for (const auto& [lamps, way] : ways_)
    if (const auto end = end_of(way)) ends.push_back(*end);
  while (!ends.empty()) {
    Eigen::Array2d weights = Eigen::Array2d::Zero(), sum_px = Eigen::Array2d::Zero();
    for (const End& end : ends) {
      weights += end.sigma_px.square().inverse();
      sum_px += end.at_px / end.sigma_px.square();
    }
    const Eigen::Array2d mean_px = sum_px / weights;
    const auto off = [&](const End& end) {
      const Eigen::Array2d sigmas = ((end.at_px - mean_px) / end.sigma_px).abs();
      return learns_yaw_ ? sigmas.maxCoeff() : sigmas.y();
    };
    const auto worst = std::ranges::max_element(ends, {}, off);
    if (off(*worst) < kAgree) return End{mean_px, weights.sqrt().inverse(), std::ssize(ends)};
    if (ends.size() < 3) return std::nullopt;
    ends.erase(worst);
  }
  return std::nullopt;
}

std::optional<Site> Aim::news() {
  constexpr double kBetter = 0.7;      // a new view costs the pairs that are being judged
  constexpr std::ptrdiff_t kSure = 4;  // ways
  const auto end = common_end();
  if (!end) return std::nullopt;
  const double sigma_px = learns_yaw_ ? end->sigma_px.maxCoeff() : end->sigma_px.y();
  if (sigma_px > kBetter * told_sigma_px_) return std::nullopt;
  told_sigma_px_ = sigma_px;
  // As a camera without roll would see it.
  const double c = std::cos(stated_.roll_rad.mean), s = std::sin(stated_.roll_rad.mean);
  const double u_px = c * end->at_px.x() - s * end->at_px.y();
  const double v_px = s * end->at_px.x() + c * end->at_px.y();
  CameraSite& camera = *site_.camera;
  if (learns_pitch_)
    camera.pitch_rad = with_stated(stated_.pitch_rad,
                                   {std::atan(v_px / focal_px_), end->sigma_px.y() / focal_px_});
  if (learns_yaw_)
    camera.yaw_rad =
        with_stated(stated_.yaw_rad, {std::atan(u_px / focal_px_ * std::cos(camera.pitch_rad.mean)),
                                      end->sigma_px.x() / focal_px_});
  if (end->ways >= kSure) {
    learns_yaw_ = learns_pitch_ = false;
    ways_.clear();
  }
  return site_;
}

}  // namespace vildar
