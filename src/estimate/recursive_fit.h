#pragma once

#include <memory>

#include "estimate/trajectory.h"

namespace vildar {

/// The camera's trajectory while the vehicle is still in view: a batch fit of the first third of a
/// second, then an extended Kalman filter over the same unknowns, frame by frame. The reference
/// time moves along with the vehicle, and its acceleration may change (`jerk`); on a dashcam the
/// reference stays and the acceleration is constant, as in the batch fit.
class RecursiveFit {
 public:
  struct Options {
    double first_s = 1.0 / 3.0;  ///< of data before the first estimate
    double jerk_mps2_per_root_s = 0.3;
  };

  /// `head` says what the vehicle is (direction, lamps); its sightings are not read. Throws
  /// std::invalid_argument where the site has no camera.
  RecursiveFit(const Site& site, const VehicleTrack& head, const Options& options);
  RecursiveFit(const Site& site, const VehicleTrack& head) : RecursiveFit(site, head, Options()) {}
  ~RecursiveFit();
  RecursiveFit(RecursiveFit&&) noexcept;
  RecursiveFit& operator=(RecursiveFit&&) noexcept;

  /// One more sighting, in order of time; a few microseconds once there is a first estimate.
  void add(const VehicleSighting& sighting);

  /// Speed over the ground at the last sighting. Misses: too_short or too_few_samples before the
  /// first estimate, else those of fit_trajectories().
  Outcome<SpeedEstimate> speed() const;
  /// The same with place and acceleration; not before there is a speed.
  std::optional<MotionState> state() const;

 private:
  struct Filter;
  std::unique_ptr<Filter> filter_;
};

}  // namespace vildar
