#include "estimate/mixture.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <vector>

#include "core/quantity.h"
#include "core/text.h"

namespace vildar {
namespace {

// Weighted mean and variance of estimates that have variances of their own.
struct Moments {
  double mean = 0.0, square = 0.0;

  void add(double weight, double value, double std) {
    mean += weight * value;
    square += weight * (value * value + std * std);
  }
  double std() const { return std::sqrt(std::max(0.0, square - mean * mean)); }
};

double normal_cdf(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }

struct Part {
  double weight, speed_mps, log_std, std_mps;
};

// Share of the mixture below `speed_mps`; each part log-normal where its interval is.
double share_below(const std::vector<Part>& parts, bool log_normal, double speed_mps) {
  double share = 0.0;
  for (const Part& part : parts)
    share +=
        part.weight * normal_cdf(log_normal ? std::log(speed_mps / part.speed_mps) / part.log_std
                                            : (speed_mps - part.speed_mps) / part.std_mps);
  return share;
}

double quantile(const std::vector<Part>& parts, bool log_normal, double wanted, double low_mps,
                double high_mps) {
  constexpr int kHalvings = 60;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle_mps = 0.5 * (low_mps + high_mps);
    (share_below(parts, log_normal, middle_mps) < wanted ? low_mps : high_mps) = middle_mps;
  }
  return 0.5 * (low_mps + high_mps);
}

}  // namespace

MotionState mixed_state(std::span<const Trajectory> trajectories, double time_s) {
  if (trajectories.size() == 1) return trajectories.front().at(time_s);
  Moments range_m, over_ground_mps;
  MotionState mixed;
  for (const Trajectory& one : trajectories) {
    const MotionState state = one.at(time_s);
    range_m.add(one.weight, state.range_m, state.range_std_m);
    over_ground_mps.add(one.weight, state.over_ground_mps, state.speed_std_mps);
    mixed.lateral_m += one.weight * state.lateral_m;
    mixed.closing_mps += one.weight * state.closing_mps;
    mixed.acceleration_mps2 += one.weight * state.acceleration_mps2;
  }
  mixed.range_m = range_m.mean;
  mixed.range_std_m = range_m.std();
  mixed.over_ground_mps = over_ground_mps.mean;
  mixed.speed_std_mps = over_ground_mps.std();
  return mixed;
}

SpeedEstimate mixed_speed(std::span<const Trajectory> trajectories, double time_s) {
  const Trajectory& likeliest = trajectories.front();
  const bool moving = likeliest.ego.moving();
  SpeedEstimate mixed =
      speed_estimate(mixed_state(trajectories, time_s), time_s, moving, likeliest.frames);
  if (trajectories.size() == 1) return mixed;
  std::vector<Part> parts;
  double low_mps = INFINITY, high_mps = 0.0;
  const bool log_normal = mixed.lo95_mps > 0.0 && !moving;
  for (const Trajectory& one : trajectories) {
    const SpeedEstimate part = speed_estimate(one.at(time_s), time_s, moving, one.frames);
    parts.push_back({one.weight, part.speed_mps, part.std_mps / part.speed_mps, part.std_mps});
    low_mps = std::min(low_mps, part.lo95_mps);
    high_mps = std::max(high_mps, part.hi95_mps);
  }
  constexpr double kTail = 0.025;
  mixed.lo95_mps = quantile(parts, log_normal, kTail, low_mps, high_mps);
  mixed.hi95_mps = quantile(parts, log_normal, 1.0 - kTail, low_mps, high_mps);
  return mixed;
}

std::string sure_lane(std::span<const Trajectory> trajectories) {
  constexpr double kSure = 0.95;
  std::map<std::string, double> weights;
  for (const Trajectory& one : trajectories) weights[one.lane] += one.weight;
  for (const auto& [lane, weight] : weights)
    if (weight >= kSure) return lane;
  return {};
}

std::string doubt_text(std::span<const Trajectory> trajectories, double time_s) {
  constexpr double kSure = 0.95;
  struct Thing {
    std::string name;
    double weight = 0.0, weighted_mps = 0.0;
  };
  std::vector<Thing> things;
  for (const Trajectory& one : trajectories) {
    const std::string name = (one.lamps.empty() ? "" : one.lamps + ", ") +
                             (one.lane.empty() ? "no lane" : "lane " + one.lane);
    auto thing = std::ranges::find(things, name, &Thing::name);
    if (thing == things.end()) thing = things.insert(thing, {name});
    thing->weight += one.weight;
    thing->weighted_mps += one.weight * std::abs(one.at(time_s).over_ground_mps);
  }
  std::ranges::stable_sort(things, std::greater(), &Thing::weight);
  if (things.front().weight >= kSure) return {};
  std::string doubt;
  for (const Thing& thing : things)
    doubt += (doubt.empty() ? "" : "; ") + thing.name + ": " + fixed_text(100.0 * thing.weight, 0) +
             " %, " + fixed_text(kmh_from_mps(thing.weighted_mps / thing.weight), 1) + " km/h";
  return doubt;
}

}  // namespace vildar
