#pragma once

#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Core>

#include "optics/yaw_rate_errors.h"
#include "types/site.h"

namespace vildar {

/// Ways in which the camera's own vehicle may have turned otherwise than is told.
inline constexpr int kOwnSwings = 8;

/// Where the camera's own vehicle stands relative to where it would be had it followed the road at
/// its speed of a reference time; zero for a fixed camera and, but for along_m and by_swing, for a
/// constant speed without yaw rates.
struct EgoDeviation {
  double along_m = 0.0;  ///< driven along the road's line y = 0 since the reference time
  double ahead_m = 0.0;  ///< along the road's line y = 0
  double left_m = 0.0;   ///< from that line
  /// Anticlockwise from that line, less what it was at the reference time.
  double heading_rad = 0.0;
  /// Driven since the reference time, where yaw rates tell the turns; else the road, of whatever
  /// radius, is followed, and this is zero.
  double way_m = 0.0;
  double springs_mps2 = 0.0;  ///< own acceleration, as its springs have followed it
  double springs_sigma_mps2 = 0.0;
  double curvature_per_m = 0.0;  ///< of the road as left_m and heading_rad take it; left: positive
  /// What along_m (and ahead_m), left_m and heading_rad change by for each second that is added to
  /// the trace's stamps.
  struct {
    double along_m = 0.0, left_m = 0.0, heading_rad = 0.0;
  } by_delay;
  /// What left_m and heading_rad change by for each unit of OwnWay's swings.
  struct Swing {
    double left_m = 0.0, heading_rad = 0.0;
  };
  std::array<Swing, kOwnSwings> by_swing{};
};

/// Where the camera's own vehicle is: in a plane in which it was at the origin and headed along x.
struct DrivenPose {
  double time_s = 0.0;
  double x_m = 0.0, y_m = 0.0;
  double heading_rad = 0.0;  ///< anticlockwise from x
  double way_m = 0.0;        ///< driven since the origin
};

/// How the camera's own vehicle drives on its road at one time.
struct OwnWay {
  /// Off the road's at that time, anticlockwise, where yaw rates are told; else in the swings.
  Uncertain heading_rad;
  Uncertain delay_s;  ///< to be added to the trace's stamps
  /// Where yaw rates are told the first is their relative error, and the others, while another
  /// vehicle is watched, are YawRateErrors, or of one ahead their bias and how it sways; else those
  /// of the heading, rad, by HeadingSwings' curves, each of which has a mean square of 1.
  std::array<Uncertain, kOwnSwings> swings{};
  double aside_std_m =
      0.0;  ///< off the road's line y = 0: half of how far it goes to and fro, as far as told
};

/// Another vehicle, seen from the own one.
struct Watched {
  TimeSpan time;
  /// It drives the same way, about as far ahead for seconds, and keeps to its lane no better: how
  /// either sways and turns is one swing of the bearings then, and tells no length.
  bool same_way = false;
};

/// Whether a trace's yaw rates tell how the own vehicle goes from side to side while another is
/// watched: by 25 times what their own noise would make of its way, and more. Else they are no
/// better than none, for a way of centimetres that passes for known is a base line for other
/// vehicles' distance. Nor where the road is told to be straight and the turns go on to one side,
/// lead farther aside than a change of lanes, or are gentle beside a vehicle ahead: they may be the
/// road's own.
bool turns_told(const EgoSite& site, const RoadSite& road, const Watched& watched);

/// Curves whose sum with independent weights is a heading (or a place in the lane) that goes to and
/// fro, alike at times apart by dt as exp(-(dt / l)^2 / 2): the first of that process's
/// Karhunen-Loeve expansion over the time in which it is watched, largest first.
class HeadingSwings {
 public:
  using Values = Eigen::Array<double, kOwnSwings, 1>;

  HeadingSwings(TimeSpan watched, double alike_s);

  /// Of the weights, for a heading of variance 1.
  const Values& variances() const { return variances_; }
  /// Before and after the time in which it is watched as at its ends.
  Values heading_at(double time_s) const;
  /// The headings' integral over time.
  Values way_s(double from_s, double to_s) const;

 private:
  static constexpr int kDegrees = 24;  // of Legendre's polynomials

  Values way_s(double time_s) const;

  TimeSpan watched_;
  Eigen::Matrix<double, kOwnSwings, kDegrees> curves_;
  Values variances_;
};

/// Motion of the camera over the ground: none, a constant speed, or a trace.
class EgoMotion {
 public:
  EgoMotion() = default;
  /// Unless told when it is watched, one without yaw rates keeps to the road.
  EgoMotion(const EgoSite& site, const RoadSite& road,
            std::optional<Watched> watched = std::nullopt);

  bool moving() const { return moving_; }
  /// Whether yaw rates tell how it turns, while another vehicle is watched or ever.
  bool knows_turns() const { return turns_known_; }
  double speed_mps(double time_s) const;
  /// Anticlockwise, as yaw rates tell it, else as the road's line y = 0 turns `way_m` from where
  /// the clip began; 0 for a fixed camera.
  double turn_rate_rad_per_s(double time_s, double way_m) const;
  /// Standard deviation of speed_mps: of all together, from the site file's `speed_mps`, and what a
  /// trace leaves open between its samples and beyond its ends while watched.
  double speed_std_mps() const {
    return moving_ ? std::hypot(site_.speed_mps.std, untold_mps_) : 0.0;
  }
  /// The first of the two.
  double stated_std_mps() const { return moving_ ? site_.speed_mps.std : 0.0; }
  EgoDeviation deviation(double reference_s, double time_s) const;
  /// As yaw rates tell it: over some seconds about `reference_s` one drives along the road for the
  /// most part. Without them one heads to and fro within the lane, and what is watched at about
  /// `range_m` may do so, too.
  OwnWay own_way(double reference_s, double range_m) const;
  /// Driven on, or back, from a pose, with turn_rate_rad_per_s.
  DrivenPose driven(const DrivenPose& from, double to_s) const;
  /// Whether a trace, if one is used, spans the interval; beyond its ends the last speed is held.
  bool covers(double from_s, double to_s) const;

 private:
  double interpolated(double time_s, double EgoSample::*field) const;
  double untold_mps(double time_s) const;
  double springs_mps2(double time_s) const;
  double springs_sigma_mps2() const;
  OwnWay lane_keeping(double reference_s, double range_m) const;
  std::array<Uncertain, kOwnSwings> errors_of_rates(double range_m) const;
  std::array<EgoDeviation::Swing, kOwnSwings> swings_by(double reference_s, double time_s) const;
  /// `turn_rate_rad_per_s(time_s, way_m)`, anticlockwise.
  template <class TurnRate>
  DrivenPose driven(DrivenPose pose, double to_s, const TurnRate& turn_rate_rad_per_s) const;

  EgoSite site_;
  double road_curvature_per_m_ = 0.0, straight_m_ = 0.0;  ///< of the road's line y = 0
  double untold_mps_ = 0.0, springs_sigma_mps2_ = 0.0;
  bool moving_ = false;
  bool turns_known_ = false;
  double curvature_per_m_ = 0.0;  ///< of the road; zero where the turns are not known
  /// Where one watches, and no yaw rates tell the turns or the other drives ahead.
  std::optional<HeadingSwings> swings_;
  double swing_rad_ = 0.0;                    ///< of the same, root mean square
  std::optional<YawRateErrors> rate_errors_;  ///< where one watches, and they do
  bool same_way_ = false;                     ///< see Watched
};

}  // namespace vildar
