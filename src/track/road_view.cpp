#include "track/road_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/quantity.h"

namespace vildar {
namespace {

constexpr double kNearest_m = 1.5;
constexpr double kFarthest_m = 400.0;
// Vehicles differ more than the site's prior for a usual car: lorries, vans, small cars.
constexpr double kLeastSeparationSigmaLn = 0.2;
constexpr double kLeastLampHeightSigma_m = 0.12;
// Vans, buses and lorries, about one vehicle in seven: their lamps stand this much higher.
constexpr double kTallerBy_m = 0.3, kTallLampSigma_m = 0.2;
// Less than -2 ln(1/6): a lone light at that height is likelier a tall vehicle's as well.
constexpr double kTallPenalty = 1.6;
// Road and camera are never level to better than this; a low camera rides on a vehicle.
const double kLeastTilt_rad = radians_from_degrees(0.15);
const double kLeastTiltLow_rad = radians_from_degrees(0.3);
constexpr double kLow_m = 2.0;
// Road camber, steering, unequal lamps.
constexpr double kLevelTolerance_rad = 0.045;

}  // namespace

RoadView::RoadView(const Site& site)
    : site_(site), camera_(*site.camera), focal_px_(camera_.focal_px()) {
  if (site.ego) ego_ = EgoMotion(*site.ego, site.road);
  const Uncertain height_m = site.lamps.height_m.value_or(Uncertain{0.68, 0.15});
  lamp_height_m_ = height_m.mean;
  lamp_height_sigma_m_ = std::max(height_m.std, kLeastLampHeightSigma_m);
  const Uncertain separation_m = site.lamps.separation_m.value_or(Uncertain{1.25, 0.12});
  separation_m_ = separation_m.mean;
  separation_sigma_ln_ = std::max(separation_m.std / separation_m.mean, kLeastSeparationSigmaLn);
  const double floor_rad = camera_.position_m().z() < kLow_m ? kLeastTiltLow_rad : kLeastTilt_rad;
  tilt_sigma_rad_ = std::max(site.camera->pitch_rad.std, floor_rad);
  level_sigma_rad_ = std::hypot(kLevelTolerance_rad, site.camera->roll_rad.std);
}

std::optional<Eigen::Vector2d> RoadView::spot_from_pixel(const Eigen::Vector2d& pixel_px) const {
  const auto normalized = camera_.normalized_from_pixel(pixel_px);
  if (!normalized) return std::nullopt;
  return Eigen::Vector2d(focal_px_ * *normalized);
}

bool RoadView::inside_image(const Eigen::Vector2d& spot_px, double margin_px) const {
  const auto pixel_px = camera_.pixel_from_normalized(spot_px / focal_px_);
  return pixel_px && pixel_px->x() > -margin_px && pixel_px->y() > -margin_px &&
         pixel_px->x() < site_.camera->width_px - 1 + margin_px &&
         pixel_px->y() < site_.camera->height_px - 1 + margin_px;
}

LampPlace RoadView::place(const Eigen::Vector2d& spot_px) const {
  const Eigen::Vector3d ray_camera(spot_px.x() / focal_px_, spot_px.y() / focal_px_, 1.0);
  const Eigen::Matrix3d& camera_from_road = camera_.camera_from_road();
  LampPlace place;
  place.slope_down = -camera_from_road.col(2).dot(ray_camera);
  const double over_lamps_m = height_over_lamps_m();
  const double raw = std::abs(over_lamps_m) > 1e-6 ? place.slope_down / over_lamps_m : 0.0;
  place.inverse_depth_per_m = std::clamp(raw, 1.0 / kFarthest_m, 1.0 / kNearest_m);

  const double heading_rad = road_heading_rad(spot_px, place);
  const double c = std::cos(heading_rad), s = std::sin(heading_rad);
  const auto flow_px = [&](const Eigen::Vector3d& direction_camera) {
    return Eigen::Vector2d(focal_px_ * direction_camera.head<2>() - spot_px * direction_camera.z());
  };
  const Eigen::Vector3d toward_camera = camera_from_road * Eigen::Vector3d(-c, -s, 0.0);
  place.across_px = flow_px(camera_from_road * Eigen::Vector3d(-s, c, 0.0));
  place.down_px = flow_px(-camera_from_road.col(2));
  place.toward_px = flow_px(toward_camera);
  place.depth_per_toward = toward_camera.z();
  const Eigen::Vector3d ahead_camera = -camera_from_road.col(0);
  place.sensor_ahead_px = flow_px(ahead_camera);
  place.depth_per_sensor_ahead = ahead_camera.z();
  return place;
}

// A low camera's elevation leaves the distance open: of the distances that it allows, taken from
// the likeliest outwards, the first on a lane counts, or the one nearest to the lanes.
double RoadView::road_heading_rad(const Eigen::Vector2d& spot_px, const LampPlace& place) const {
  constexpr double kAllowed_sigma = 2.0;
  constexpr int kSteps = 8;
  if (site_.road.kind != RoadKind::curved || !site_.road.radius_m) return 0.0;
  RoadPosition best = road_at(spot_px, place.inverse_depth_per_m);
  double beyond_m = beyond_lanes_m(best.lateral_m);
  const double step_per_m = kAllowed_sigma / kSteps * inverse_depth_sigma_per_m(place);
  for (int i = 1; i <= kSteps && beyond_m > 0.0; ++i)
    for (const double side : {-1.0, 1.0}) {
      const RoadPosition at =
          road_at(spot_px, std::clamp(place.inverse_depth_per_m + side * i * step_per_m,
                                      1.0 / kFarthest_m, 1.0 / kNearest_m));
      if (beyond_lanes_m(at.lateral_m) >= beyond_m) continue;
      beyond_m = beyond_lanes_m(at.lateral_m);
      best = at;
    }
  return path_point(best.along_m, best.lateral_m, bend_of(site_.road), site_.road.straight_m.mean,
                    site_.road.radius_m->mean)
      .heading_rad;
}

double RoadView::slope_sigma(double inverse_depth_per_m) const {
  return std::hypot(tilt_sigma_rad_, lamp_height_sigma_m_ * inverse_depth_per_m);
}

double RoadView::gap_sigma_m(double inverse_depth_per_m) const {
  return std::sqrt(2.0) * lamp_height_sigma_m_ /
         (std::abs(height_over_lamps_m()) * inverse_depth_per_m);
}

double RoadView::inverse_depth_sigma_per_m(const LampPlace& place) const {
  // A lamp of a lorry level with a low camera may be near as well as far.
  const double over_m = std::max(std::abs(height_over_lamps_m()), kTallLampSigma_m);
  return slope_sigma(place.inverse_depth_per_m) / over_m;
}

PairFit RoadView::fit_pair(const Eigen::Vector2d& left_px, const Eigen::Vector2d& right_px,
                           double sigma_px) const {
  const Eigen::Vector2d middle_px = 0.5 * (left_px + right_px);
  const LampPlace at = place(middle_px);
  const Eigen::Vector2d vector_px = right_px - left_px;
  const double across = vector_px.dot(at.across_px) / at.across_px.squaredNorm();
  PairFit fit;
  fit.width_per_depth = std::abs(across);
  if (!(fit.width_per_depth > 0.0)) {
    fit.chi2 = std::numeric_limits<double>::infinity();
    return fit;
  }
  fit.off_level_px = (vector_px - across * at.across_px).norm();
  // Another heading turns the line across the road in its own plane, which is seen at this slope.
  const double turned_rad = site_.camera->yaw_rad.std * at.slope_down;
  fit.level_sigma_px =
      std::hypot(sigma_px, std::hypot(level_sigma_rad_, turned_rad) * vector_px.norm());
  const double sigma_ln = std::hypot(separation_sigma_ln_, sigma_px / vector_px.norm());
  const double wanted = std::log(fit.width_per_depth / separation_m_);
  const double tall_m = lamp_height_m_ + kTallerBy_m;
  const DepthFit car =
      fit_depth(at.slope_down, wanted, sigma_ln, lamp_height_m_, lamp_height_sigma_m_);
  const DepthFit tall = fit_depth(at.slope_down, wanted, sigma_ln, tall_m, kTallLampSigma_m);
  const DepthFit& best = car.chi2 < tall.chi2 + kTallPenalty ? car : tall;
  fit.inverse_depth_per_m =
      std::clamp(best.inverse_depth_per_m, 1.0 / kFarthest_m, 1.0 / kNearest_m);
  fit.depth_chi2 = std::min(car.chi2, tall.chi2 + kTallPenalty);
  fit.depth_sigma_ln = best.sigma_ln;
  fit.chi2 = fit.depth_chi2 + std::pow(fit.off_level_px / fit.level_sigma_px, 2);
  return fit;
}

// One unknown, x = ln(inverse depth): the separation asks for width_per_depth / separation, the
// elevation for slope / height over the lamps.
RoadView::DepthFit RoadView::fit_depth(double slope_down, double wanted, double sigma_ln,
                                       double lamp_m, double lamp_sigma_m) const {
  constexpr int kSteps = 6;
  const double over_m = camera_.position_m().z() - lamp_m;
  double x = wanted, width_miss = 0.0, slope_miss = 0.0, curvature = 0.0, slope_change = 0.0;
  for (int step = 0; step < kSteps; ++step) {
    const double inverse_depth = std::exp(x);
    const double sigma = std::hypot(tilt_sigma_rad_, lamp_sigma_m * inverse_depth);
    width_miss = (x - wanted) / sigma_ln;
    slope_miss = (over_m * inverse_depth - slope_down) / sigma;
    slope_change = over_m * inverse_depth / sigma;
    const double gradient = width_miss / sigma_ln + slope_miss * slope_change;
    curvature = 1.0 / (sigma_ln * sigma_ln) + slope_change * slope_change;
    x -= std::clamp(gradient / curvature, -0.7, 0.7);
  }
  const double from_slope_ln = 1.0 / std::max(std::abs(slope_change), 1e-6);
  return {std::exp(x), width_miss * width_miss + slope_miss * slope_miss,
          std::hypot(sigma_ln, from_slope_ln)};
}

Eigen::Vector2d RoadView::bearing(const Eigen::Vector2d& spot_px) const {
  const Eigen::Vector3d ray_road =
      camera_.camera_from_road().transpose() * Eigen::Vector3d(spot_px.x(), spot_px.y(), focal_px_);
  return ray_road.tail<2>() / ray_road.x();
}

Eigen::Vector2d RoadView::turning_pxps(const Eigen::Vector2d& spot_px, double time_s) const {
  const double left_rad_per_s = ego_.turn_rate_rad_per_s(time_s, ego_.speed_mps(time_s) * time_s);
  const Eigen::Vector3d ray(spot_px.x() / focal_px_, spot_px.y() / focal_px_, 1.0);
  const Eigen::Vector3d turned = left_rad_per_s * ray.cross(camera_.camera_from_road().col(2));
  return focal_px_ * turned.head<2>() - spot_px * turned.z();
}

double RoadView::speeding_up_m(double from_s, double to_s) const {
  constexpr int kSteps = 20;
  const double step_s = (to_s - from_s) / kSteps, at_first_mps = ego_speed_mps(from_s);
  double more_m = 0.0;
  for (int i = 0; i < kSteps; ++i)
    more_m += step_s * (ego_speed_mps(from_s + (i + 0.5) * step_s) - at_first_mps);
  return more_m;
}

std::vector<double> RoadView::lane_centres_m(Direction direction) const {
  std::vector<double> centres_m;
  for (const LaneSite& lane : site_.road.lanes)
    if (lane.direction == direction) centres_m.push_back(lane.lateral_m.mean);
  return centres_m;
}

RoadPosition RoadView::road_at(const Eigen::Vector2d& spot_px, double inverse_depth_per_m) const {
  const Eigen::Vector3d ray_camera(spot_px.x() / focal_px_, spot_px.y() / focal_px_, 1.0);
  const Eigen::Vector3d point_m = camera_.position_m() + camera_.camera_from_road().transpose() *
                                                             ray_camera / inverse_depth_per_m;
  return road_position(site_.road, point_m.x(), point_m.y());
}

std::optional<Eigen::Vector2d> RoadView::spot_at(const RoadPosition& at) const {
  constexpr double kLeastDepth_m = 0.1;
  const bool bends = site_.road.radius_m.has_value();
  const auto ground =
      path_point(at.along_m, at.lateral_m, bends ? bend_of(site_.road) : 0.0,
                 site_.road.straight_m.mean, bends ? site_.road.radius_m->mean : 0.0);
  const Eigen::Vector3d point_camera_m =
      camera_.camera_from_road() *
      (Eigen::Vector3d(ground.x_m, ground.y_m, lamp_height_m_) - camera_.position_m());
  if (!(point_camera_m.z() > kLeastDepth_m)) return std::nullopt;
  return Eigen::Vector2d(focal_px_ * point_camera_m.head<2>() / point_camera_m.z());
}

double RoadView::lateral_sigma_m(double inverse_depth_per_m) const {
  const double depth_m = 1.0 / inverse_depth_per_m;
  double bend_m = 0.0;
  if (bends() && site_.road.radius_m) {
    const double on_bend_m = std::max(0.0, depth_m - site_.road.straight_m.mean);
    const Uncertain& radius_m = *site_.road.radius_m;
    bend_m =
        on_bend_m / radius_m.mean *
        std::hypot(0.5 * on_bend_m * radius_m.std / radius_m.mean, bend_begins_m(site_.road).std);
  }
  return std::hypot(site_.camera->position_m[1].std, site_.camera->yaw_rad.std * depth_m, bend_m);
}

double RoadView::beyond_lanes_m(double lateral_m) const {
  if (site_.road.lanes.empty()) return 0.0;
  double low_m = std::numeric_limits<double>::infinity(), high_m = -low_m;
  for (const LaneSite& lane : site_.road.lanes) {
    low_m = std::min(low_m, lane.lateral_m.mean - 0.5 * lane.width_m);
    high_m = std::max(high_m, lane.lateral_m.mean + 0.5 * lane.width_m);
  }
  return std::max({0.0, low_m - lateral_m, lateral_m - high_m});
}

std::optional<double> RoadView::off_lane_centre_m(double lateral_m) const {
  std::optional<double> nearest_m;
  for (const LaneSite& lane : site_.road.lanes) {
    const double off_m = std::abs(lateral_m - lane.lateral_m.mean);
    if (!nearest_m || off_m < *nearest_m) nearest_m = off_m;
  }
  return nearest_m;
}

}  // namespace vildar
