#include "track/vehicle_body.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/LU>

namespace vildar {
namespace {

/// A vehicle's body, a box that reaches back from its lamps.
class Body {
 public:
  static std::optional<Body> of(const Eigen::Vector2d& left_px, const Eigen::Vector2d& right_px,
                                double inverse_depth_per_m, double width_per_depth,
                                const RoadView& view) {
    Body body;
    body.middle_px_ = 0.5 * (left_px + right_px);
    const LampPlace at = view.place(body.middle_px_);
    Eigen::Matrix2d axes;
    axes << at.across_px, at.down_px;
    if (!(std::abs(axes.determinant()) > 1e-9) || !(inverse_depth_per_m > 0.0)) return std::nullopt;
    body.inverse_depth_per_m_ = inverse_depth_per_m;
    body.metres_ = axes.inverse() / inverse_depth_per_m;
    body.back_per_m_ = -axes.inverse() * at.toward_px;
    body.half_width_m_ = 0.5 * width_per_depth / inverse_depth_per_m;
    return body;
  }
  /// Right of and below the lamps' middle, of a light so far behind them (m).
  Eigen::Vector2d place_m(const Eigen::Vector2d& at_px, double back_m) const {
    const double farther = 1.0 + back_m * inverse_depth_per_m_;
    return metres_ * (at_px - middle_px_) * farther - back_per_m_ * back_m;
  }
  bool holds(const Eigen::Vector2d& place_m) const {
    constexpr double kBesideLamps_m = 0.45, kOver_m = 2.2, kUnder_m = 0.6;
    return std::abs(place_m.x()) < half_width_m_ + kBesideLamps_m && place_m.y() < kUnder_m &&
           place_m.y() > -kOver_m;
  }
  double metre_of_px() const { return metres_.col(1).norm(); }

 private:
  Eigen::Vector2d middle_px_, back_per_m_;
  Eigen::Matrix2d metres_;
  double inverse_depth_per_m_ = 0.0, half_width_m_ = 0.0;
};

constexpr double kSlice_m = 1.5;

// Lamps over a cab or a box stand up to 4.5 m behind headlamps; from behind a vehicle what is
// farther before its tail lamps than a roof's bar is hidden by what carries these.
int slices_of(const Vehicle& vehicle) { return vehicle.kind == LampKind::taillamp ? 3 : 4; }

/// A light and both lamps of a vehicle in one frame.
struct SeenTogether {
  Eigen::Vector2d light_px, left_px, right_px;
};

// Of the last frames.
std::vector<SeenTogether> seen_together(const Lamp& light, const Vehicle& vehicle) {
  constexpr std::int64_t kMostFrames = 200;
  const std::int64_t since = light.records.back().frame - kMostFrames;
  const auto from = [since](const std::vector<LampRecord>& records) {
    return std::ranges::lower_bound(records, since, {}, &LampRecord::frame);
  };
  const auto &lefts = vehicle.left->records, &rights = vehicle.right->records;
  std::vector<SeenTogether> seen;
  for (auto one = from(light.records), left = from(lefts), right = from(rights);
       one != light.records.end() && left != lefts.end() && right != rights.end();) {
    const std::int64_t last = std::max({one->frame, left->frame, right->frame});
    if (std::min({one->frame, left->frame, right->frame}) == last)
      seen.push_back({(one++)->at_px, (left++)->at_px, (right++)->at_px});
    else
      for (auto* at : {&one, &left, &right}) *at += (*at)->frame < last;
  }
  return seen;
}

}  // namespace

bool stands_within_body(const Lamp& light, const Vehicle& vehicle, const RoadView& view) {
  const auto body = Body::of(vehicle.left->at_px(), vehicle.right->at_px(),
                             vehicle.inverse_depth_per_m, vehicle.width_per_depth, view);
  if (!body) return false;
  for (int slice = 0; slice < slices_of(vehicle); ++slice)
    if (body->holds(body->place_m(light.at_px(), slice * kSlice_m))) return true;
  return false;
}

bool changes_place_on_body(const Lamp& light, const Vehicle& vehicle, const RoadView& view) {
  constexpr double kMost_m = 0.5, kMost_px = 2.0;
  constexpr double kLeastHalfway = 0.1, kMostHalfway = 0.95;  // a steady way, not one stray look
  constexpr std::size_t kFewest = 10;
  const std::vector<SeenTogether> seen = seen_together(light, vehicle);
  if (seen.size() < kFewest) return false;
  std::array<std::optional<Body>, 3> bodies;
  const std::array at{std::size_t{1}, seen.size() / 2, seen.size() - 2};
  double most_m = kMost_m;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const SeenTogether& one = seen[at[i]];
    const PairFit fit = view.fit_pair(one.left_px, one.right_px, 1.0);
    bodies[i] =
        Body::of(one.left_px, one.right_px, fit.inverse_depth_per_m, fit.width_per_depth, view);
    if (!bodies[i]) return false;
    most_m = std::max(most_m, kMost_px * bodies[i]->metre_of_px());
  }
  for (int slice = 0; slice < slices_of(vehicle); ++slice) {
    const auto place_m = [&](std::size_t i) {
      return bodies[i]->place_m(seen[at[i]].light_px, slice * kSlice_m);
    };
    const Eigen::Vector2d first_m = place_m(0), moved_m = place_m(2) - first_m;
    const double halfway = (place_m(1) - first_m).dot(moved_m) / moved_m.squaredNorm();
    if (!(moved_m.norm() >= most_m) || halfway < kLeastHalfway || halfway > kMostHalfway)
      return false;
  }
  return true;
}

}  // namespace vildar
