#include "track/lamp_way.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vildar {
namespace {

struct Range {
  std::size_t first, end;
};

/// The `most` pairs nearest in time.
Range about(const std::vector<PairPlace>& pairs, double time_s, std::size_t most) {
  const auto next = static_cast<std::size_t>(
      std::ranges::lower_bound(pairs, time_s, {}, &PairPlace::time_s) - pairs.begin());
  Range range{next, next};
  while (range.end - range.first < most && (range.first > 0 || range.end < pairs.size())) {
    const bool back = range.end == pairs.size() ||
                      (range.first > 0 &&
                       time_s - pairs[range.first - 1].time_s < pairs[range.end].time_s - time_s);
    back ? --range.first : ++range.end;
  }
  return range;
}

/// Depth over time: a straight line.
class Course {
 public:
  Course(const std::vector<PairPlace>& pairs, const std::vector<double>& depth_m, Range range)
      : count_(static_cast<double>(range.end - range.first)) {
    for (std::size_t i = range.first; i < range.end; ++i) {
      mean_s_ += pairs[i].time_s / count_;
      mean_m_ += depth_m[i] / count_;
    }
    double cross = 0.0, spread_m2 = 0.0;
    for (std::size_t i = range.first; i < range.end; ++i) {
      const double off_s = pairs[i].time_s - mean_s_, off_m = depth_m[i] - mean_m_;
      spread_s2_ += off_s * off_s;
      cross += off_s * off_m;
      spread_m2 += off_m * off_m;
    }
    speed_mps_ = cross / spread_s2_;
    scatter_m2_ = std::max(0.0, spread_m2 - speed_mps_ * cross) / (count_ - 2.0);
  }
  double depth_m(double time_s) const { return mean_m_ + speed_mps_ * (time_s - mean_s_); }
  double sigma_m(double time_s) const {
    const double off_s = time_s - mean_s_;
    return std::sqrt(scatter_m2_ * (1.0 / count_ + off_s * off_s / spread_s2_));
  }

 private:
  double count_, mean_s_ = 0.0, mean_m_ = 0.0, spread_s2_ = 0.0;
  double speed_mps_ = 0.0, scatter_m2_ = 0.0;
};

}  // namespace

LampWay::LampWay(std::vector<PairPlace> pairs, const RoadView& view)
    : pairs_(std::move(pairs)), view_(view) {
  for (const PairPlace& pair : pairs_)
    depth_m_.push_back(1.0 / view.fit_pair(pair.left_px, pair.right_px, 1.0).inverse_depth_per_m);
}

std::optional<LampWay::Place> LampWay::at(double time_s) const {
  constexpr std::size_t kFewest = 8, kMost = 20, kNearest = 5;
  constexpr double kSigmas = 3.0, kAcceleration_mps2 = 3.0, kSideways_mps = 0.5;
  constexpr double kLeastDepth_m = 1.0;
  if (view_.moving_sensor()) return std::nullopt;
  const Range window = about(pairs_, time_s, kMost);
  if (window.end - window.first < kFewest) return std::nullopt;
  const Course course(pairs_, depth_m_, window);
  const double depth_m = course.depth_m(time_s);
  if (!(depth_m > kLeastDepth_m)) return std::nullopt;

  // Each of the nearest moved on to that time, exact on a straight road.
  Place place{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero(), 0.0, 0.0};
  const Range nearest = about(pairs_, time_s, kNearest);
  const double share = 1.0 / static_cast<double>(nearest.end - nearest.first);
  double since_s = 0.0;
  for (std::size_t i = nearest.first; i < nearest.end; ++i) {
    const PairPlace& pair = pairs_[i];
    const double further_m = depth_m - course.depth_m(pair.time_s);
    const auto moved_px = [&](const Eigen::Vector2d& from_px) -> Eigen::Vector2d {
      const LampPlace from = view_.place(from_px);
      return from_px + further_m / (from.depth_per_toward * depth_m) * from.toward_px;
    };
    place.left_px += share * moved_px(pair.left_px);
    place.right_px += share * moved_px(pair.right_px);
    since_s += share * std::abs(time_s - pair.time_s);
  }
  const LampPlace at = view_.place(0.5 * (place.left_px + place.right_px));
  const double along_m =
      kSigmas * course.sigma_m(time_s) + 0.5 * kAcceleration_mps2 * since_s * since_s;
  place.along = at.toward_px.normalized();
  place.along_px = along_m / depth_m * at.toward_px.norm();
  place.across_px = kSideways_mps * since_s / depth_m * at.across_px.norm();
  return place;
}

void drop_beside_the_way(std::vector<SeenVehicle>& seen, const RoadView& view) {
  constexpr double kNear_px = 3.0, kNearShare = 0.5;  // of the distance of the two lamps
  std::vector<PairPlace> pairs;
  for (const SeenVehicle& one : seen) {
    const VehicleSighting& sighting = one.sighting;
    if (!sighting.left || !sighting.right || !one.fits) continue;
    const auto left_px = view.spot_from_pixel(sighting.left->centre_px);
    const auto right_px = view.spot_from_pixel(sighting.right->centre_px);
    if (left_px && right_px) pairs.push_back({seconds_of(sighting.time), *left_px, *right_px});
  }
  const LampWay way(std::move(pairs), view);
  std::erase_if(seen, [&](const SeenVehicle& one) {
    const VehicleSighting& sighting = one.sighting;
    if (sighting.both_in_one || sighting.left.has_value() == sighting.right.has_value())
      return false;
    const auto place = way.at(seconds_of(sighting.time));
    const auto at_px =
        view.spot_from_pixel((sighting.left ? sighting.left : sighting.right)->centre_px);
    if (!place || !at_px) return false;
    const Eigen::Vector2d off_px = *at_px - (sighting.left ? place->left_px : place->right_px);
    const double along_px = off_px.dot(place->along);
    const double near_px =
        std::max(kNear_px, kNearShare * (place->right_px - place->left_px).norm());
    return std::abs(along_px) > near_px + place->along_px ||
           (off_px - along_px * place->along).norm() > near_px + place->across_px;
  });
}

}  // namespace vildar
