#include "estimate/metric_priors.h"

#include <algorithm>
#include <cmath>

#include "estimate/lane_choice.h"
#include "optics/camera.h"
#include "optics/road.h"

namespace vildar {
namespace {

// Spread of tail lamps about what the site file says of headlamps: UN R48 lets rear position lamps
// stand from 0.35 to 1.5 m high.
constexpr double kTailLampSpread_m = 0.2;
// A quantity that the site file calls known is taken as good to this.
constexpr double kKnown_m = 0.001;
// A lane's true curvature and the path driven in it differ by this share of the radius at least.
constexpr double kKnownRadius = 0.005;
// Of the vehicles with two lamps, those of which one alone is seen: the other is broken or hidden.
constexpr double kOneLampShare = 0.05;

Uncertain with_floor(Uncertain value, double floor_m = kKnown_m) {
  return {value.mean, std::max(value.std, floor_m)};
}

std::optional<Uncertain> tail_prior_m(const std::optional<Uncertain>& head_m,
                                      const std::optional<Uncertain>& tail_m) {
  if (tail_m || !head_m) return tail_m;
  return Uncertain{head_m->mean, std::max(head_m->std, kTailLampSpread_m)};
}

// The class' own, what the site says of all tail lamps, or its headlamps'. A vehicle with one
// headlamp has one tail lamp.
LampReading tails_of(const LampClass& one, const LampsSite& lamps) {
  const auto own_or = [](const std::optional<Uncertain>& own_m, const auto& common_m) {
    return own_m ? own_m : common_m;
  };
  LampReading reading{one.id, one.share, {}, {}};
  reading.height_m = tail_prior_m(one.height_m, own_or(one.tail_height_m, lamps.tail_height_m));
  reading.separation_m =
      one.separation_m
          ? tail_prior_m(one.separation_m, own_or(one.tail_separation_m, lamps.tail_separation_m))
          : one.tail_separation_m;
  return reading;
}

LampReading reading_of(const LampClass& one, const LampsSite& lamps, LampKind kind) {
  if (kind == LampKind::taillamp) return tails_of(one, lamps);
  return {one.id, one.share, one.height_m, one.separation_m};
}

}  // namespace

std::vector<LampReading> lamp_readings(const LampsSite& lamps, LampKind kind, bool pairs) {
  const bool tails = kind == LampKind::taillamp;
  std::vector<LampReading> readings;
  if (!tails || lamps.classes_tell_tails())
    for (const LampClass& one : lamps.classes) {
      LampReading reading = reading_of(one, lamps, kind);
      if (pairs && !reading.separation_m) continue;
      if (!pairs && reading.separation_m) reading.share *= kOneLampShare;
      readings.push_back(reading);
    }
  if (!readings.empty()) return readings;
  if (!tails) return {{"", 1.0, lamps.height_m, lamps.separation_m}};
  return {{"", 1.0, tail_prior_m(lamps.height_m, lamps.tail_height_m),
           tail_prior_m(lamps.separation_m, lamps.tail_separation_m)}};
}

MetricPriors metric_priors(const Site& site, const LampReading& lamps) {
  const CameraSite& camera = *site.camera;
  MetricPriors priors;
  if (lamps.height_m)
    priors.drop_m = with_floor({camera.position_m[2].mean - lamps.height_m->mean,
                                std::hypot(lamps.height_m->std, camera.position_m[2].std)});
  if (lamps.separation_m) priors.separation_m = with_floor(*lamps.separation_m);
  if (site.road.radius_m)
    priors.radius_m = with_floor(*site.road.radius_m, kKnownRadius * site.road.radius_m->mean);
  if (site.road.radius_m && bend_of(site.road) != 0.0) {
    const Uncertain straight_m = bend_begins_m(site.road);
    if (straight_m.std > 0.0) priors.straight_m = straight_m;
  }
  priors.turn_rad = {Uncertain{0.0, camera.yaw_rad.std}, Uncertain{0.0, camera.pitch_rad.std},
                     Uncertain{0.0, camera.roll_rad.std}};
  priors.log_focal = {0.0, camera.focal_std_px / Camera(camera).focal_px()};
  return priors;
}

Uncertain lateral_from_camera_m(const LaneSite& lane, const Site& site, const LampReading& lamps,
                                bool pairs) {
  const Uncertain prior_m = lane_prior_m(lane);
  const Uncertain& camera_m = site.camera->position_m[1];
  // One lamp stands for its vehicle: it may be either of a pair, or ride anywhere in the lane.
  double aside_m = 0.0;
  if (!pairs) aside_m = lamps.separation_m ? 0.5 * lamps.separation_m->mean : kHalfPair_m;
  return {prior_m.mean - camera_m.mean, std::hypot(std::hypot(prior_m.std, camera_m.std), aside_m)};
}

}  // namespace vildar
