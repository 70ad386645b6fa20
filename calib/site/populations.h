#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "estimate/trajectory.h"
#include "types/site.h"

namespace vildar {

/// What a pass has one value of and shares with others.
enum class Shared { drop, separation, lateral, yaw, pitch, roll, focal };
constexpr bool is_length(Shared kind) { return kind <= Shared::lateral; }
constexpr bool is_turn(Shared kind) { return kind >= Shared::yaw && kind <= Shared::roll; }

/// Value of a shared quantity on a path: ln of a length in metres (as all lengths of a path grow
/// together, in their logarithms that is one step for all, which favours no scale), radians from
/// the present mean pose, or ln of the focal length over the present one.
template <class T>
T shared_value(Shared kind, const T* path) {
  using std::abs;
  using std::log;
  switch (kind) {
    case Shared::drop: return path[kLogScale] + log(abs(path[kDrop]));
    case Shared::separation: return path[kLogScale] + path[kLogSeparation];
    case Shared::lateral: return path[kLogScale] + log(abs(path[kLateral]));
    case Shared::yaw: return path[kYaw];
    case Shared::pitch: return path[kPitch];
    case Shared::roll: return path[kRoll];
    case Shared::focal: return path[kLogFocal];
  }
  return T(0.0);
}

/// The vehicles of a site as regards one quantity: their shared_value is normal with unknown mean
/// and spread.
struct Population {
  std::string key;  ///< of the site file
  Shared kind = Shared::drop;
  bool tail = false;           ///< of vehicles that show tail lamps
  std::string lane;            ///< of a lateral offset
  Uncertain stated;            ///< of a vehicle, metres; else as shared_value
  Uncertain mean;              ///< prior
  double likely_spread = 0.0;  ///< prior of the spread, worth `spread_weight` passes
  double spread_weight = 0.0;
  double spread = 0.0;   ///< present estimate
  double present = 0.0;  ///< present estimate of the mean

  /// Mean of the quantity itself, and what a small step of its shared_value is worth there.
  double mean_value() const;
  double per_step() const { return is_length(kind) ? std::abs(mean_value()) : 1.0; }
};

/// A pass's part in a population; what else than the spread parts it from the mean.
struct Membership {
  std::size_t population = 0;
  double extra_std = 0.0;
};

/// One pass: its trajectory without the priors that the populations stand for.
struct Pass {
  std::size_t track = 0;  ///< index into the tracks given
  GeometryProblem problem;
  PathVector path = PathVector::Zero();
  std::vector<int> free;  ///< path parameters not held fixed
  std::vector<Membership> members;
};

/// The passes' shared quantities as populations. `stated` is the site file, `present` the same with
/// the camera angles and the focal length that the trajectories were fitted with: turns and focal
/// lengths are relative to these.
class PopulationList {
 public:
  PopulationList(Site stated, Site present);

  /// The pass of a fitted trajectory; populations appear as passes ask for them.
  Pass pass_of(std::size_t track, LampKind kind, const Trajectory& trajectory);
  std::vector<Population>& all() { return populations_; }

 private:
  std::size_t index_of(const Population& population);

  Site stated_, present_;
  std::vector<Population> populations_;
};

}  // namespace vildar
