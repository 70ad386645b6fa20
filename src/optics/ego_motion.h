#pragma once

#include "types/site.h"

namespace vildar {

/// Where the camera's own vehicle stands relative to where it would be had it followed the road at
/// its speed of a reference time; zero for a fixed camera and, but for along_m, for a constant
/// speed without yaw rates.
struct EgoDeviation {
  double along_m = 0.0;  ///< driven along the road's line y = 0 since the reference time
  double ahead_m = 0.0;  ///< along the road's line y = 0
  double left_m = 0.0;   ///< from that line
  /// Anticlockwise from that line, less what it was at the reference time.
  double heading_rad = 0.0;
  /// Driven since the reference time, where yaw rates tell the turns; else the road, of whatever
  /// radius, is followed, and this is zero.
  double way_m = 0.0;
  double curvature_per_m = 0.0;  ///< of the road as left_m and heading_rad take it; left: positive
  /// What along_m (and ahead_m), left_m and heading_rad change by for each second that is added to
  /// the trace's stamps.
  struct {
    double along_m = 0.0, left_m = 0.0, heading_rad = 0.0;
  } by_delay;
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
  Uncertain heading_rad;     ///< off the road's, anticlockwise
  Uncertain delay_s;         ///< to be added to the trace's stamps
  Uncertain turns;           ///< relative error of its yaw rates
  double aside_std_m = 0.0;  ///< off the road's line y = 0: half of how far it goes to and fro
};

/// Motion of the camera over the ground: none, a constant speed, or a trace.
class EgoMotion {
 public:
  EgoMotion() = default;
  EgoMotion(const EgoSite& site, const RoadSite& road);

  bool moving() const { return moving_; }
  double speed_mps(double time_s) const;
  /// Standard deviation of speed_mps, from the site file's `speed_mps`; 0 where it is called known.
  double speed_std_mps() const { return moving_ ? site_.speed_mps.std : 0.0; }
  EgoDeviation deviation(double reference_s, double time_s) const;
  /// As yaw rates tell it: over some seconds about `reference_s` one drives along the road for the
  /// most part. Without them the heading is zero, and called known.
  OwnWay own_way(double reference_s) const;
  /// Driven on, or back, from a pose: it turns as yaw rates say, else as the road's line y = 0
  /// turns `way_m` from where the clip began.
  DrivenPose driven(const DrivenPose& from, double to_s) const;
  /// Whether a trace, if one is used, spans the interval; beyond its ends the last speed is held.
  bool covers(double from_s, double to_s) const;

 private:
  double interpolated(double time_s, double EgoSample::*field) const;
  /// `turn_rate_rad_per_s(time_s, way_m)`, anticlockwise.
  template <class TurnRate>
  DrivenPose driven(DrivenPose pose, double to_s, const TurnRate& turn_rate_rad_per_s) const;

  EgoSite site_;
  double road_curvature_per_m_ = 0.0, straight_m_ = 0.0;  ///< of the road's line y = 0
  bool moving_ = false;
  bool turns_known_ = false;
  double curvature_per_m_ = 0.0;  ///< of the road; zero where the turns are not known
};

}  // namespace vildar
