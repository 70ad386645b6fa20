#include "estimate/side_light.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>

#include "core/median.h"
#include "estimate/mixture.h"

namespace vildar {
namespace {

// A lone light in one frame, and where the middle of the carrier's pair is: tangents across and
// down from the camera.
struct Look {
  double carrier_m;
  double across, down;
  double carrier_across;
};

Eigen::Vector2d tangents(const Eigen::Vector2d& bearing_rad) {
  return {std::tan(bearing_rad.x()), -std::tan(bearing_rad.y()) / std::cos(bearing_rad.x())};
}

bool shows_both(const TrackRow& row) {
  return row.bearing_rad && row.bearing_left_rad && row.bearing_right_rad;
}

bool has_pair(const VehicleEstimate& one) { return std::ranges::any_of(one.rows, shows_both); }

// Where its pair is not seen the carrier is where its motion has it.
std::vector<Look> looks_at(const VehicleEstimate& light, const VehicleEstimate& carrier) {
  constexpr double kLongest_s = 1.5;  // before it is seen, and after
  const Eigen::Vector3d& camera_m = carrier.trajectories.front().problem.setting.camera_m;
  const double from_s = carrier.result.t_first_s - kLongest_s;
  const double to_s = carrier.result.t_last_s + kLongest_s;
  const auto frame_of = [](const TrackRow& row) { return row.sighting.frame; };
  std::vector<Look> found;
  auto pair = carrier.rows.begin();
  for (const TrackRow& lone : light.rows) {
    const auto& lone_rad = lone.bearing_left_rad ? lone.bearing_left_rad : lone.bearing_right_rad;
    if (!lone_rad || lone.time_s < from_s || lone.time_s > to_s) continue;
    const Eigen::Vector2d at = tangents(*lone_rad);
    pair = std::ranges::lower_bound(pair, carrier.rows.end(), frame_of(lone), {}, frame_of);
    if (pair != carrier.rows.end() && frame_of(*pair) == frame_of(lone) && shows_both(*pair) &&
        pair->range_m) {
      found.push_back(
          {*pair->range_m - camera_m.x(), at.x(), at.y(), tangents(*pair->bearing_rad).x()});
    } else {
      const MotionState there = mixed_state(carrier.trajectories, lone.time_s);
      const double ahead_m = there.range_m - camera_m.x();
      if (ahead_m > 0.0)
        found.push_back({ahead_m, at.x(), at.y(), (there.lateral_m - camera_m.y()) / ahead_m});
    }
  }
  return found;
}

double separation_m(const VehicleEstimate& carrier) {
  const double camera_m = carrier.trajectories.front().problem.setting.camera_m.x();
  std::vector<double> found_m;
  for (const TrackRow& row : carrier.rows)
    if (shows_both(row) && row.range_m)
      found_m.push_back(
          (*row.range_m - camera_m) *
          (tangents(*row.bearing_left_rad) - tangents(*row.bearing_right_rad)).norm());
  return found_m.empty() ? 0.0 : median(std::move(found_m));
}

// A place on the carrier's body, in metres from the middle of its pair, and how well all bearings
// are those of it.
struct BodyPlace {
  double beside_m, behind_m, behind_sigma_m, misfit_m;
};

// Least squares of x = (beside, behind, below the camera): at the light's distance, which is the
// carrier's and `behind`, both tangents are those of one place.
BodyPlace place_of(const std::vector<Look>& looks) {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  const auto rows_of = [](const Look& look) {
    Eigen::Matrix<double, 2, 3> slopes;
    slopes << 1.0, -look.across, 0.0, 0.0, -look.down, 1.0;
    return slopes;
  };
  const auto wanted_m = [](const Look& look) -> Eigen::Vector2d {
    return look.carrier_m * Eigen::Vector2d(look.across - look.carrier_across, look.down);
  };
  for (const Look& look : looks) {
    const auto slopes = rows_of(look);
    const double weight = 1.0 / (look.carrier_m * look.carrier_m);
    information += weight * slopes.transpose() * slopes;
    gradient += weight * slopes.transpose() * wanted_m(look);
  }
  const auto solver = information.ldlt();
  const Eigen::Vector3d place_m = solver.solve(gradient);
  double square_m2 = 0.0, square = 0.0;
  for (const Look& look : looks) {
    const double off_m = (wanted_m(look) - rows_of(look) * place_m).norm();
    square_m2 += off_m * off_m;
    square += off_m * off_m / (look.carrier_m * look.carrier_m);
  }
  const double degrees = 2.0 * static_cast<double>(looks.size()) - 3.0;
  const double behind_variance = solver.solve(Eigen::Vector3d::UnitY()).y();
  return {place_m.x(), place_m.y(), std::sqrt(square / degrees * behind_variance),
          std::sqrt(square_m2 / degrees)};
}

}  // namespace

bool is_side_marker(const VehicleEstimate& light, const VehicleEstimate& carrier) {
  constexpr std::size_t kFewest = 10;
  constexpr double kNearer = 1.25, kMisfit_m = 0.05, kMostSigma_m = 0.7;
  constexpr double kLeastBehind_m = 1.0, kLorry_m = 18.0, kCar_m = 5.0, kLorrysPair_m = 1.55;
  constexpr double kLeastBeside = 0.52, kMostBeside = 0.85;  // of the pair's separation
  if (light.trajectories.empty() || carrier.trajectories.empty() || has_pair(light) ||
      light.result.direction != carrier.result.direction ||
      carrier.trajectories.front().problem.setting.bend != 0.0)
    return false;
  const std::vector<Look> looks = looks_at(light, carrier);
  const double pair_m = separation_m(carrier);
  if (looks.size() < kFewest || !(pair_m > 0.0)) return false;
  const auto [nearest, farthest] = std::ranges::minmax(looks, {}, &Look::carrier_m);
  if (farthest.carrier_m < kNearer * nearest.carrier_m) return false;
  const BodyPlace place = place_of(looks);
  const double beside = std::abs(place.beside_m) / pair_m;
  return place.misfit_m < kMisfit_m && place.behind_sigma_m < kMostSigma_m &&
         place.behind_m > kLeastBehind_m &&
         place.behind_m < (pair_m > kLorrysPair_m ? kLorry_m : kCar_m) && beside > kLeastBeside &&
         beside < kMostBeside;
}

}  // namespace vildar
