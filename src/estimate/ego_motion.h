#pragma once

#include <optional>

#include "types/site.h"

namespace vildar {

/// Where the camera's own vehicle stands relative to where it would be had it gone straight on at
/// its speed of a reference time; zero for a fixed camera and for a constant speed.
struct EgoDeviation {
  double ahead_m = 0.0;
  double left_m = 0.0;
  double heading_rad = 0.0;  ///< anticlockwise since the reference time
};

/// Motion of the camera over the ground: none, a constant speed, or a trace.
class EgoMotion {
 public:
  EgoMotion() = default;
  explicit EgoMotion(const EgoSite& site) : site_(site), moving_(true) {}

  bool moving() const { return moving_; }
  double speed_mps(double time_s) const;
  /// Standard deviation of speed_mps, from the site file's `speed_mps`; 0 where it is called known.
  double speed_std_mps() const { return moving_ ? site_.speed_mps.std : 0.0; }
  EgoDeviation deviation(double reference_s, double time_s) const;
  /// Whether a trace, if one is used, spans the interval; beyond its ends the last speed is held.
  bool covers(double from_s, double to_s) const;

 private:
  double interpolated(double time_s, double EgoSample::*field) const;

  EgoSite site_;
  bool moving_ = false;
};

}  // namespace vildar
