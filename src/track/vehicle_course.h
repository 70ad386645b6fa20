#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "track/lamp.h"

namespace vildar {

/// A frame of a vehicle: where the lamps stood that were seen alone, as in RoadView.
struct LampLook {
  double time_s = 0.0;
  std::optional<Eigen::Vector2d> left_px, right_px;
};

/// Of the middle of both lamps, by separation and elevation; of the one that there is, by
/// elevation. Nothing where both stand in one column.
std::optional<RoadPosition> place_of(const LampLook& look, const RoadView& view);

/// In order of time. What held both lamps in one blob is left out.
std::vector<LampLook> looks_of(const std::vector<LampRecord>& left,
                               const std::vector<LampRecord>& right);

/// The course of a vehicle from the places of its lamps in the image: at constant speed along the
/// road, in one place across it. Of what tells the distance, that the vehicle keeps to its place
/// across the road weighs most from beside it, for a lamp's column is surer than its row on a wet
/// road; its elevation and the separation of its lamps, which is a free number of each vehicle,
/// from straight ahead. Robust least squares (Cauchy weights). The speed is relative to the sensor.
class VehicleCourse {
 public:
  /// Nothing where too little tells it: less than 8 looks, 4 of them at both lamps. Where none is,
  /// it is taken for a vehicle of one lamp.
  static std::optional<VehicleCourse> of(std::span<const LampLook> looks, const RoadView& view);

  /// Where later looks, one or more, say that a vehicle of this speed and separation is, at their
  /// mean time.
  std::optional<VehicleCourse> placed(std::span<const LampLook> looks, const RoadView& view) const;

  double time_s() const { return time_s_; }  ///< mean, of the looks
  double along_m(double time_s) const;
  double along_sigma_m(double time_s) const;
  double lateral_m() const { return state_[kLateral]; }

 private:
  enum { kAlong, kSpeed, kLateral, kSeparation, kStates };
  using State = Eigen::Vector<double, kStates>;
  using Information = Eigen::Matrix<double, kStates, kStates>;

  static std::optional<VehicleCourse> fit(std::span<const LampLook> looks, double time_s,
                                          const State& prior, const Information& prior_information,
                                          const RoadView& view);

  double time_s_ = 0.0;
  State state_ = State::Zero();
  Information covariance_ = Information::Zero();
};

}  // namespace vildar
