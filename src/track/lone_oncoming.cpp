#include "track/lone_oncoming.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/LU>

#include "core/quantity.h"
#include "core/robust_line.h"

namespace vildar {
namespace {

constexpr double kLowest_m = 0.3, kHighest_m = 1.6;  // lamps of anything that drives
constexpr double kLoneSigmas = 2.5;
constexpr std::size_t kFewestLooks = 8;  // looks

// Where a light would stand that the camera drives by, from the camera.
struct StandingPlace {
  double aside_m = 0.0, aside_sigma_m = 0.0;  ///< to the left
  double above_m = 0.0, above_sigma_m = 0.0;
};

struct Look {
  double driven_m;          ///< by the camera, until the last look
  Eigen::Vector2d bearing;  ///< left and up, over depth
};

// Every so many of all: more tell no more, for errors of neighbouring frames are alike.
std::size_t looked_at_every(const std::vector<LampRecord>& records) {
  constexpr std::size_t kMost = 80;
  return (records.size() + kMost - 1) / kMost;
}

std::vector<Look> looks_of(const std::vector<LampRecord>& records, const RoadView& view) {
  std::vector<Look> looks;
  const std::size_t every = looked_at_every(records);
  double driven_m = 0.0;
  for (std::size_t i = records.size(); i-- > 0;) {
    const double time_s = seconds_of(records[i].time);
    if (i + 1 < records.size()) {
      const double later_s = seconds_of(records[i + 1].time);
      driven_m += (later_s - time_s) * view.ego_speed_mps(0.5 * (time_s + later_s));
    }
    if (i % every == 0) looks.push_back({driven_m, view.bearing(records[i].at_px)});
  }
  std::ranges::reverse(looks);
  return looks;
}

// One bearing over all looks as place / depth + an offset that is nought but for `offset_sigma`.
struct Line {
  double place_m = 0.0, place_sigma_m = 0.0, chi2 = 0.0;
};

Line line_through(const std::vector<Look>& looks, int axis, double last_m, double sigma,
                  double offset_sigma) {
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  information(1, 1) = std::pow(offset_sigma, -2);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  const double weight = 1.0 / (sigma * sigma);
  for (const Look& look : looks) {
    const Eigen::Vector2d slope(1.0 / (last_m + look.driven_m), 1.0);
    information += weight * slope * slope.transpose();
    sum += weight * look.bearing[axis] * slope;
  }
  const Eigen::Matrix2d covariance = information.inverse();
  const Eigen::Vector2d at = covariance * sum;
  Line line{at[0], std::sqrt(covariance(0, 0)), std::pow(at[1] / offset_sigma, 2)};
  for (const Look& look : looks) {
    const double off = look.bearing[axis] - at[0] / (last_m + look.driven_m) - at[1];
    line.chi2 += weight * off * off;
  }
  return line;
}

// The distance at the last look by which a standing light explains its way best; nothing where that
// is at an end of what is tried.
std::optional<StandingPlace> standing_place(const std::vector<Look>& looks, const RoadView& view) {
  constexpr double kSigma_px = 2.0, kFramesAlike = 4.0;
  constexpr double kNearest_m = 1.0, kFarthest_m = 200.0;
  constexpr int kSteps = 200;
  const double kSway_rad = radians_from_degrees(0.5);  // of a camera that drives
  const double sigma = kSigma_px * std::sqrt(kFramesAlike) / view.focal_px();
  const double step = std::log(kFarthest_m / kNearest_m) / kSteps;
  std::vector<double> chi2;
  std::size_t best = 0;
  const auto lines_at = [&](std::size_t i) {
    const double last_m = kNearest_m * std::exp(step * static_cast<double>(i));
    return std::array{
        line_through(looks, 0, last_m, sigma, std::hypot(view.yaw_sigma_rad(), kSway_rad)),
        line_through(looks, 1, last_m, sigma, std::hypot(view.slope_sigma(0.0), kSway_rad))};
  };
  for (std::size_t i = 0; i <= kSteps; ++i) {
    const auto lines = lines_at(i);
    chi2.push_back(lines[0].chi2 + lines[1].chi2);
    if (chi2[i] < chi2[best]) best = i;
  }
  if (best == 0 || best == kSteps) return std::nullopt;
  const auto [aside, above] = lines_at(best);
  const double scatter = std::sqrt(
      std::max(1.0, chi2[best] / std::max(1.0, 2.0 * static_cast<double>(looks.size()) - 3.0)));
  // The profile rises by one where the distance is one sigma off.
  std::size_t from = best, to = best;
  while (from > 0 && chi2[from] < chi2[best] + scatter * scatter) --from;
  while (to < kSteps && chi2[to] < chi2[best] + scatter * scatter) ++to;
  const double distance_sigma_ln = 0.5 * step * static_cast<double>(to - from);
  const auto sigma_of = [&](const Line& line) {
    return std::hypot(scatter * line.place_sigma_m, line.place_m * distance_sigma_ln);
  };
  return StandingPlace{aside.place_m, sigma_of(aside), above.place_m, sigma_of(above)};
}

bool on_carriageway(const StandingPlace& place, const RoadView& view) {
  constexpr double kKerb_m = 0.5;
  const double at_m = view.camera_lateral_m() + place.aside_m;
  const double slack_m = kLoneSigmas * place.aside_sigma_m + kKerb_m;
  return view.beyond_lanes_m(at_m - slack_m) <= 0.0 && view.beyond_lanes_m(at_m + slack_m) <= 0.0;
}

// Bearings of a light, headed `goes` away from the camera or toward it.
struct LaneWay {
  bool goes = false;
  std::vector<double> times_s;
  std::vector<Eigen::Vector2d> bearings;
};

// Whether it keeps about one speed `aside_m` from the camera, which looks `yaw_rad` further left
// than its site file says.
bool drives_along(const LaneWay& seen, double aside_m, double yaw_rad, const RoadView& view) {
  constexpr double kLeastAside_m = 2.0, kNearest_m = 3.0, kFarthest_m = 150.0, kTimesNearer = 1.33;
  constexpr double kSlowest_mps = 3.0, kFastest_mps = 70.0, kMostOff_px = 3.0;
  constexpr double kAcceleration_mps2 = 0.5;
  if (std::abs(aside_m) < kLeastAside_m) return false;
  std::vector<double> ahead_m;
  const double cosine = std::cos(yaw_rad), sine = std::sin(yaw_rad);
  for (const Eigen::Vector2d& bearing : seen.bearings) {
    const double deep = cosine - sine * bearing.x();  // along the road, per depth as stated
    const double at_m = aside_m / (sine + cosine * bearing.x()) * deep;
    const double up_m = view.camera_height_m() + bearing.y() / deep * at_m;
    const double slack_m = kLoneSigmas * view.slope_sigma(0.0) * at_m;
    if (!(at_m > kNearest_m && at_m < kFarthest_m) || up_m + slack_m < kLowest_m ||
        up_m - slack_m > kHighest_m)
      return false;
    ahead_m.push_back(at_m);
  }
  const auto [nearest, farthest] = std::ranges::minmax_element(ahead_m);
  const RobustLine way = least_deviations_line(seen.times_s, ahead_m);
  const double drives_mps = (seen.goes ? 1.0 : -1.0) * way.slope;
  if (*farthest < kTimesNearer * *nearest || drives_mps < kSlowest_mps || drives_mps > kFastest_mps)
    return false;
  // One that speeds up or brakes evenly is off its line by that far at either end and in the
  // middle.
  const double lasts_s = seen.times_s.back() - seen.times_s.front();
  const double changes_m = kAcceleration_mps2 * lasts_s * lasts_s / 16.0;
  double sum = 0.0;
  for (std::size_t i = 0; i < ahead_m.size(); ++i) {
    const double at_m = way.at(seen.times_s[i]);
    const double px_per_m = view.focal_px() * aside_m / (at_m * ahead_m[i]);
    const double most_px = std::hypot(kMostOff_px, px_per_m * changes_m);
    sum += std::pow(px_per_m * (at_m - ahead_m[i]) / most_px, 2);
  }
  return sum < static_cast<double>(ahead_m.size());
}

}  // namespace

bool cannot_stand(const std::vector<LampRecord>& records, const RoadView& view) {
  if (records.size() < kFewestLooks || view.bends()) return false;
  const auto place = standing_place(looks_of(records, view), view);
  if (!place) return false;
  const double up_m = view.camera_height_m() + place->above_m;
  const double slack_m = kLoneSigmas * place->above_sigma_m;
  return up_m + slack_m < 0.0 || (up_m - slack_m < kHighest_m && on_carriageway(*place, view));
}

bool comes_in_a_lane(const std::vector<LampRecord>& records, const RoadView& view) {
  constexpr double kSlowest_mps = 3.0, kFastest_mps = 70.0;
  constexpr double kWithinLane_m = 0.6;  // two sigmas of where in it vehicles drive
  if (records.size() < kFewestLooks || view.bends()) return false;
  const std::vector<Look> looks = looks_of(records, view);
  const auto standing = standing_place(looks, view);
  if (!standing || !on_carriageway(*standing, view)) return false;
  const StandingPlace& place = *standing;
  const double camera_m = view.camera_lateral_m();
  const double ego_mps =
      looks.front().driven_m / (seconds_of(records.back().time) - seconds_of(records.front().time));
  for (const double lane_m : view.lane_centres_m(Direction::oncoming)) {
    const double aside_m = lane_m - camera_m;
    const double times = aside_m / place.aside_m;  // as fast as the camera comes nearer
    const double times_sigma =
        std::abs(times) * std::hypot(place.aside_sigma_m / place.aside_m, kWithinLane_m / aside_m);
    const double drives_mps = ego_mps * (times - 1.0), sigma_mps = ego_mps * times_sigma;
    const double up_m = view.camera_height_m() + times * place.above_m;
    const double slack_m =
        kLoneSigmas * std::hypot(times * place.above_sigma_m, times_sigma * place.above_m);
    if (drives_mps > std::max(kSlowest_mps, sigma_mps) && drives_mps < kFastest_mps &&
        up_m + slack_m > kLowest_m && up_m - slack_m < kHighest_m)
      return true;
  }
  return false;
}

bool passes_in_a_lane(const std::vector<LampRecord>& records, LampKind kind, const RoadView& view) {
  // Cameras that look aside by steps as far as may be; between them a way errs by less than is
  // allowed, for a line takes up most of it.
  constexpr double kYawStep_px = 8.0, kYawSigmas = 2.0;
  if (records.size() < kFewestLooks || view.bends() || view.moving_sensor()) return false;
  LaneWay seen{kind == LampKind::taillamp, {}, {}};
  for (std::size_t i = 0; i < records.size(); i += looked_at_every(records)) {
    seen.times_s.push_back(seconds_of(records[i].time));
    seen.bearings.push_back(view.bearing(records[i].at_px));
  }
  const double step_rad = kYawStep_px / view.focal_px();
  const auto steps = static_cast<int>(kYawSigmas * view.yaw_sigma_rad() / step_rad);
  for (const double lane_m :
       view.lane_centres_m(seen.goes ? Direction::receding : Direction::oncoming))
    for (int step = -steps; step <= steps; ++step)
      if (drives_along(seen, lane_m - view.camera_lateral_m(), step * step_rad, view)) return true;
  return false;
}

}  // namespace vildar
