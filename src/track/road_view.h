#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "optics/camera.h"
#include "optics/ego_motion.h"
#include "optics/picture.h"
#include "optics/road.h"
#include "types/site.h"

namespace vildar {

/// A spot of the undistorted image read as a lamp at lamp height. "Spot" coordinates are
/// undistorted pixels from the principal point: the focal length times (x/z, y/z) in camera axes.
struct LampPlace {
  double slope_down = 0.0;  ///< fall of the ray per metre of depth; negative above the horizon
  double inverse_depth_per_m = 0.0;  ///< from the slope, kept within what a lamp in view can have
  /// Spot movement per unit of (metres x inverse depth) to the left across the road, downwards, and
  /// along the road toward the sensor. To first order in metres over depth.
  Eigen::Vector2d across_px, down_px, toward_px;
  /// Change of depth per metre travelled toward the sensor.
  double depth_per_toward = 0.0;
  /// The same for metres that the sensor drives ahead: elsewhere in a bend the road's line differs.
  Eigen::Vector2d sensor_ahead_px;
  double depth_per_sensor_ahead = 0.0;
};

/// How a pair of spots fares as the two lamps of one vehicle.
struct PairFit {
  double chi2 = 0.0;            ///< of level and depth together; infinite where the two coincide
  double depth_chi2 = 0.0;      ///< separation against elevation
  double depth_sigma_ln = 0.0;  ///< of ln depth, separation less elevation
  double off_level_px = 0.0;    ///< from the line across the road through the other
  double level_sigma_px = 0.0;
  double inverse_depth_per_m = 0.0;  ///< of the best compromise between separation and elevation
  double width_per_depth = 0.0;      ///< separation over depth, straight from the image
};

/// The camera over the road, in the terms that telling lamps apart needs.
class RoadView {
 public:
  /// Needs site.camera.
  explicit RoadView(const Site& site);

  /// Nothing where the lens model has no inverse.
  std::optional<Eigen::Vector2d> spot_from_pixel(const Eigen::Vector2d& pixel_px) const;
  bool inside_image(const Eigen::Vector2d& spot_px, double margin_px) const;

  LampPlace place(const Eigen::Vector2d& spot_px) const;
  /// Order of the two does not matter. Lamps may stand at the height of a car's or, less likely,
  /// at that of a van's or lorry's: the better of the two is taken.
  PairFit fit_pair(const Eigen::Vector2d& left_px, const Eigen::Vector2d& right_px,
                   double sigma_px) const;

  /// How far to the left of straight ahead a spot is seen, and how far up, over depth.
  Eigen::Vector2d bearing(const Eigen::Vector2d& spot_px) const;
  /// Road position of a lamp seen at a spot with a given inverse depth (1/m).
  RoadPosition road_at(const Eigen::Vector2d& spot_px, double inverse_depth_per_m) const;
  /// Where a lamp at lamp height falls; nothing behind the camera.
  std::optional<Eigen::Vector2d> spot_at(const RoadPosition& at) const;
  /// What the camera's place and heading, and the begin and radius of a bend, leave open of the
  /// lateral place of all that it sees there.
  double lateral_sigma_m(double inverse_depth_per_m) const;
  /// Distance in metres beyond the outermost lane edges; 0 on the lanes or without lanes.
  double beyond_lanes_m(double lateral_m) const;
  /// Distance to the nearest lane centre; nothing without lanes.
  std::optional<double> off_lane_centre_m(double lateral_m) const;

  /// Speed of the sensor itself along the road; 0 for a fixed one.
  double ego_speed_mps(double time_s) const { return ego_.speed_mps(time_s); }
  bool moving_sensor() const { return ego_.moving(); }
  /// Spot movement (px/s), that of near and far ones alike, by which the sensor itself turns; zero
  /// for a fixed one.
  Eigen::Vector2d turning_pxps(const Eigen::Vector2d& spot_px, double time_s) const;
  /// By how much more the sensor has driven, from one time to a later one, than at its speed of the
  /// first.
  double speeding_up_m(double from_s, double to_s) const;

  bool bends() const { return site_.road.kind == RoadKind::curved; }
  std::vector<double> lane_centres_m(Direction direction) const;
  double camera_lateral_m() const { return camera_.position_m().y(); }
  double camera_height_m() const { return camera_.position_m().z(); }
  double exposure_s() const { return site_.camera->exposure_s.value_or(kUnknownExposure_s); }
  double yaw_sigma_rad() const { return site_.camera->yaw_rad.std; }
  double focal_px() const { return focal_px_; }
  double picture_px_per_usual() const {
    return px_per_usual(site_.camera->width_px, site_.camera->height_px);
  }
  double lamp_height_m() const { return lamp_height_m_; }
  double separation_m() const { return separation_m_; }
  double height_over_lamps_m() const { return camera_.position_m().z() - lamp_height_m_; }
  /// Of the slope that a lamp at a given inverse depth shows: tilt of camera and road, lamp height.
  double slope_sigma(double inverse_depth_per_m) const;
  /// Of the distance between two vehicles one behind the other, as elevation tells it: their lamps
  /// need not stand at one height.
  double gap_sigma_m(double inverse_depth_per_m) const;
  /// Standard deviation of the inverse depth that the elevation of a spot gives.
  double inverse_depth_sigma_per_m(const LampPlace& place) const;

 private:
  static constexpr double kUnknownExposure_s = 0.02;  // of most clips at night, at most
  struct DepthFit {
    double inverse_depth_per_m, chi2, sigma_ln;
  };
  /// Heading of the road under a lamp, anticlockwise from the sensor's +x.
  double road_heading_rad(const Eigen::Vector2d& spot_px, const LampPlace& place) const;
  DepthFit fit_depth(double slope_down, double wanted, double sigma_ln, double lamp_m,
                     double lamp_sigma_m) const;

  Site site_;
  Camera camera_;
  EgoMotion ego_;
  double focal_px_;
  double lamp_height_m_, lamp_height_sigma_m_;
  double separation_m_, separation_sigma_ln_;
  double tilt_sigma_rad_;
  double level_sigma_rad_;  ///< of the line between the lamps of a vehicle, but for the heading
};

}  // namespace vildar
