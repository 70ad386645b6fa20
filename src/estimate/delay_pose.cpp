#include "estimate/delay_pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/Geometry>

#include "optics/incidence.h"
#include "optics/road.h"

namespace vildar {
namespace {

constexpr double kLeastBaseline_m = 0.10;
constexpr double kLampHeight_m = 0.68;  // where the site tells none
constexpr double kWidest_rad = 1.4;     // off its axis a photodiode is taken to see

Eigen::Vector3d place_of(const PhotodiodeSite& photodiode) {
  return {photodiode.position_m[0].mean, photodiode.position_m[1].mean,
          photodiode.position_m[2].mean};
}

constexpr double kRoadside_m = 4.0;  // from a photodiode to the lane, where none is given

double lateral_of(const PhotodiodeSite& photodiode, const RoadSite& road) {
  return road_position(road, photodiode.position_m[0].mean, photodiode.position_m[1].mean)
      .lateral_m;
}

// The lanes in which a vehicle may come.
std::vector<Uncertain> lanes_of(const Site& site, const PhotodiodeSite& photodiode) {
  std::vector<Uncertain> oncoming, any;
  for (const LaneSite& lane : site.road.lanes) {
    any.push_back(lane.lateral_m);
    if (lane.direction == Direction::oncoming) oncoming.push_back(lane.lateral_m);
  }
  if (!oncoming.empty()) return oncoming;
  if (!any.empty()) return any;
  const double lateral_m = lateral_of(photodiode, site.road);
  return {{lateral_m - kRoadside_m, 0.0}, {lateral_m + kRoadside_m, 0.0}};
}

// From the path of the lamps of the farthest lane: of several any may be the vehicle's.
double perpendicular_m(const Site& site, const PhotodiodeSite& photodiode, double height_m) {
  const double lateral_m = lateral_of(photodiode, site.road);
  double aside_m = site.road.lanes.empty() ? kRoadside_m : 0.0;
  for (const LaneSite& lane : site.road.lanes)
    aside_m = std::max(aside_m, std::abs(lane.lateral_m.mean - lateral_m));
  return std::hypot(aside_m, photodiode.position_m[2].mean - height_m);
}

// From a lamp to a photodiode, off the lamp's axis. Of headlamps ln of the light falls with the
// square of the azimuth and with the angle above the axis, in each by as much as this; ripples and
// the edges of low beams tell rays apart beside that.
struct Ray {
  double azimuth_rad, elevation_rad;
  double log_received;  // ln of the light of any unit, but for the beam
  double log_secant;    // of the angle off the axis, -ln of its cosine

  static constexpr Uncertain kByAzimuth2{9.0, 4.0}, kByElevation{8.0, 4.0};
  static constexpr double kRipplePerAzimuth = 2.0, kRipplePerElevation = 4.0;  // nat per radian

  double log_light() const {
    return log_received - kByAzimuth2.mean * azimuth_rad * azimuth_rad -
           kByElevation.mean * elevation_rad;
  }
  // Sigma of how unlike the light of two rays is.
  double doubt(const Ray& other) const {
    const double azimuth2 = azimuth_rad * azimuth_rad - other.azimuth_rad * other.azimuth_rad;
    const double elevation_rad_off = elevation_rad - other.elevation_rad;
    return std::hypot(std::hypot(kByAzimuth2.std * azimuth2, kByElevation.std * elevation_rad_off),
                      kRipplePerAzimuth * (azimuth_rad - other.azimuth_rad),
                      kRipplePerElevation * elevation_rad_off);
  }
};

// One of the ways in which lamps may pass: a lane of a road.
struct Passing {
  double bend = 0.0, straight_m = 0.0, radius_m = INFINITY, lateral_m = 0.0, height_m = 0.0;

  // How far along this lane it is to where `photodiode` stands beside it.
  double along_m(const RoadSite& road, const PhotodiodeSite& photodiode) const {
    const RoadPosition beside =
        road_position(road, photodiode.position_m[0].mean, photodiode.position_m[1].mean);
    if (bend == 0.0 || beside.along_m <= straight_m) return beside.along_m;
    return straight_m + (beside.along_m - straight_m) * (radius_m - bend * lateral_m) /
                            (radius_m - bend * beside.lateral_m);
  }

  // A lamp `along_m` along the lane; nothing where it is out of view.
  std::optional<Ray> ray(const PhotodiodeSite& photodiode, double along_m) const {
    const PathPoint<double> lamp = path_point(along_m, lateral_m, bend, straight_m, radius_m);
    const Eigen::Vector3d apart_m =
        Eigen::Vector3d(lamp.x_m, lamp.y_m, height_m) - place_of(photodiode);
    const double distance_m = apart_m.norm();
    const double incidence_cos = apart_m.dot(axis_of(photodiode)) / distance_m;
    const double rim_rad = std::min(photodiode.half_field_of_view_rad, kWidest_rad);
    if (incidence_cos < std::cos(rim_rad)) return std::nullopt;
    return Ray{std::remainder(std::atan2(apart_m.y(), apart_m.x()) - lamp.heading_rad, 2.0 * kPi),
               std::atan2(-apart_m.z(), std::hypot(apart_m.x(), apart_m.y())),
               std::log(incidence_cos) - 2.0 * std::log(distance_m), -std::log(incidence_cos)};
  }
};

// Of light from 150 m to 84 degrees off the road, or to the rim of the view.
std::vector<OffAxis> off_axis(const Passing& passing, double along_m,
                              const PhotodiodeSite& photodiode, double perpendicular_m) {
  constexpr int kDistances = 32;
  constexpr double kFrom = 0.1, kTo_m = 150.0;
  std::vector<OffAxis> found;
  const double from_m = kFrom * perpendicular_m;
  for (int i = 0; i < kDistances; ++i) {
    const double ahead_m =
        from_m * std::pow(kTo_m / from_m, static_cast<double>(i) / (kDistances - 1));
    if (const auto ray = passing.ray(photodiode, along_m + ahead_m))
      found.push_back({ahead_m, ray->log_secant});
  }
  return found;
}

struct Range {
  double least = INFINITY, most = -INFINITY;

  void add(double value) {
    least = std::min(least, value);
    most = std::max(most, value);
  }
  bool empty() const { return least > most; }
  double middle() const { return 0.5 * (least + most); }
  double std() const { return (most - least) / std::sqrt(12.0); }
};

std::vector<RoadSite> roads_of(const RoadSite& road) {
  constexpr double kOfRange = 1.7320508075688772;  // half a uniform range over its sigma
  std::vector<RoadSite> found{road};
  if (road.kind == RoadKind::straight) return found;
  for (const double sigmas : {-kOfRange, kOfRange}) {
    const double radius_m = road.radius_m->mean + sigmas * road.radius_m->std;
    if (road.radius_m->std == 0.0 || !(radius_m > 0.0)) continue;
    found.push_back(road);
    found.back().radius_m->mean = radius_m;
  }
  const Uncertain straight_m = bend_begins_m(road);
  if (straight_m.std > 0.0)
    for (const double sigmas : {-kOfRange, kOfRange}) {
      found.push_back(road);
      found.back().straight_m.mean = std::max(0.0, straight_m.mean + sigmas * straight_m.std);
    }
  return found;
}

// Whether the bend has begun where the photodiode stands: where it begins ahead of two, it does so
// at another distance from each.
bool bends_past(const RoadSite& road, const PhotodiodeSite& photodiode) {
  constexpr double kSlack_m = 0.5;
  return road.radius_m && photodiode.position_m[0].mean > road.straight_m.mean - kSlack_m;
}

struct Way {
  Passing passing;
  double near_m, far_m;  // along it, to where the photodiodes stand beside it

  Way(const Passing& by, double near_along_m, double far_along_m)
      : passing(by), near_m(near_along_m), far_m(far_along_m) {}
};

// Empty where the two are alike, nothing where they are too unlike.
std::optional<std::vector<UnlikeLight>> unlike_lights(std::span<const Way> ways,
                                                      const PhotodiodeSite& near,
                                                      const PhotodiodeSite& far,
                                                      double perpendicular_m) {
  constexpr std::size_t kDistances = 32;
  constexpr double kFrom = 0.6;  // of the perpendicular distance: 59 degrees off the road
  constexpr double kTo_m = 150.0, kLeastFrom_m = 0.3;
  constexpr double kFaintestLn = -4.6;  // a hundredth of the most: less is no part of a pass
  constexpr double kMostUnlike = 0.15, kMostDoubt = 0.10, kOwnDoubt = 0.25;
  constexpr double kAheadLn = 0.2;  // how well it is known how far ahead a vehicle is
  constexpr double kNothing = 1e-6;
  std::vector<double> ahead_m{std::max(kLeastFrom_m, kFrom * perpendicular_m)};
  const double step = std::pow(kTo_m / ahead_m.front(), 1.0 / (kDistances - 1));
  while (ahead_m.size() < kDistances) ahead_m.push_back(step * ahead_m.back());
  std::vector<Range> ratios(ahead_m.size());
  std::vector<double> doubts(ahead_m.size(), 0.0);
  for (const Way& way : ways) {
    std::vector<std::pair<std::size_t, std::array<Ray, 2>>> seen;
    double brightest = -INFINITY;
    for (std::size_t i = 0; i < ahead_m.size(); ++i) {
      const auto to_near = way.passing.ray(near, way.near_m + ahead_m[i]);
      const auto to_far = way.passing.ray(far, way.far_m + ahead_m[i]);
      if (!to_near || !to_far) continue;
      seen.push_back({i, {*to_near, *to_far}});
      brightest = std::max(brightest, to_near->log_light());
    }
    for (const auto& [i, rays] : seen) {
      if (rays[0].log_light() < brightest + kFaintestLn) continue;
      ratios[i].add(rays[1].log_light() - rays[0].log_light());
      doubts[i] = std::max(doubts[i], rays[0].doubt(rays[1]));
    }
  }
  std::vector<UnlikeLight> found;
  if (std::ranges::all_of(ratios, &Range::empty))
    return std::nullopt;  // no stretch is seen by both
  for (std::size_t i = 0; i < ahead_m.size(); ++i)
    if (!ratios[i].empty())
      found.push_back({ahead_m[i], ratios[i].middle(),
                       std::hypot(ratios[i].std(), kOwnDoubt * ratios[i].middle(), doubts[i])});
  for (std::size_t i = 0; i < found.size(); ++i) {
    const UnlikeLight& before = found[i == 0 ? 0 : i - 1];
    const UnlikeLight& after = found[std::min(i + 1, found.size() - 1)];
    if (&before != &after)
      found[i].doubt = std::hypot(found[i].doubt, kAheadLn * (after.log_ratio - before.log_ratio) /
                                                      std::log(after.ahead_m / before.ahead_m));
    if (!(std::abs(found[i].log_ratio) < kMostUnlike) || !(found[i].doubt < kMostDoubt))
      return std::nullopt;
  }
  if (std::ranges::all_of(found, [](const UnlikeLight& one) {
        return std::abs(one.log_ratio) < kNothing && one.doubt < kNothing;
      }))
    found.clear();
  return found;
}

}  // namespace

Outcome<PairPose> pair_pose(const Site& site, const PhotodiodeSite& near,
                            const PhotodiodeSite& far) {
  if (site.road.kind == RoadKind::curved && !bends_past(site.road, near))
    return Miss::outside_model;
  const double height_m = site.lamps.height_m ? site.lamps.height_m->mean : kLampHeight_m;
  PairPose pose;
  pose.perpendicular_m = perpendicular_m(site, far, height_m);
  Range baseline_m;
  double lane_std_m = 0.0;  // what the place within its lane does to the way
  std::vector<Way> ways;
  for (const RoadSite& road : roads_of(site.road))
    for (const Uncertain& lane : lanes_of(site, far)) {
      const double radius_m = road.radius_m ? road.radius_m->mean : INFINITY;
      const Passing passing{bend_of(road), road.straight_m.mean, radius_m, lane.mean, height_m};
      if (!(radius_m - passing.bend * lane.mean > 0.0)) return Miss::outside_model;
      const Way& way =
          ways.emplace_back(passing, passing.along_m(road, near), passing.along_m(road, far));
      baseline_m.add(way.far_m - way.near_m);
      if (passing.bend != 0.0)
        lane_std_m = std::max(lane_std_m, std::abs(way.far_m - way.near_m) * lane.std /
                                              (radius_m - passing.bend * lane.mean));
    }
  pose.baseline_m = {baseline_m.middle(),
                     std::hypot(std::hypot(near.position_m[0].std, far.position_m[0].std),
                                lane_std_m, baseline_m.std())};
  if (pose.baseline_m.mean < kLeastBaseline_m) return Miss::no_scale;
  auto unlike = unlike_lights(ways, near, far, pose.perpendicular_m);
  if (!unlike) return Miss::outside_model;
  pose.unlike = std::move(*unlike);
  pose.off_axis = off_axis(ways.front().passing, ways.front().far_m, far, pose.perpendicular_m);
  return pose;
}

UnlikeLight unlike_at(std::span<const UnlikeLight> unlike, double ahead_m) {
  if (unlike.empty()) return {ahead_m, 0.0, 0.0};
  const auto above = std::ranges::lower_bound(unlike, ahead_m, {}, &UnlikeLight::ahead_m);
  if (above == unlike.begin()) return unlike.front();
  if (above == unlike.end()) return unlike.back();
  const UnlikeLight& one = *std::prev(above);
  const double share = (ahead_m - one.ahead_m) / (above->ahead_m - one.ahead_m);
  return {ahead_m, std::lerp(one.log_ratio, above->log_ratio, share),
          std::lerp(one.doubt, above->doubt, share)};
}

double log_secant_at(std::span<const OffAxis> off_axis, double ahead_m) {
  if (off_axis.empty()) return 0.0;
  const auto above = std::ranges::lower_bound(off_axis, ahead_m, {}, &OffAxis::ahead_m);
  if (above == off_axis.begin()) return off_axis.front().log_secant;
  if (above == off_axis.end()) return off_axis.back().log_secant;
  const OffAxis& one = *std::prev(above);
  const double share = (ahead_m - one.ahead_m) / (above->ahead_m - one.ahead_m);
  return std::lerp(one.log_secant, above->log_secant, share);
}

}  // namespace vildar
