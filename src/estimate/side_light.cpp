#include "estimate/side_light.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>

#include "core/by_frame.h"
#include "core/median.h"

namespace vildar {
namespace {

// A lone light and a carrier's pair in one frame: tangents across and down from the camera.
struct BothSeen {
  double carrier_m;
  double across, down;
  double carrier_across, separation_m;
};

Eigen::Vector2d tangents(const Eigen::Vector2d& bearing_rad) {
  return {std::tan(bearing_rad.x()), -std::tan(bearing_rad.y()) / std::cos(bearing_rad.x())};
}

bool shows_both(const TrackRow& row) {
  return row.bearing_rad && row.bearing_left_rad && row.bearing_right_rad;
}

std::vector<BothSeen> both_seen(const VehicleEstimate& light, const VehicleEstimate& carrier) {
  std::vector<BothSeen> found;
  for_each_common_frame(
      light.rows, carrier.rows, [](const TrackRow& row) { return row.sighting.frame; },
      [&](const TrackRow& lone, const TrackRow& pair) {
        const auto& lone_rad =
            lone.bearing_left_rad ? lone.bearing_left_rad : lone.bearing_right_rad;
        if (!lone_rad || !shows_both(pair) || !pair.range_m) return;
        const Eigen::Vector2d at = tangents(*lone_rad);
        const double apart =
            (tangents(*pair.bearing_left_rad) - tangents(*pair.bearing_right_rad)).norm();
        found.push_back({*pair.range_m, at.x(), at.y(), tangents(*pair.bearing_rad).x(),
                         *pair.range_m * apart});
      });
  return found;
}

// A place on the carrier's body, in metres from the middle of its pair, and how well all bearings
// are those of it.
struct BodyPlace {
  double beside_m, behind_m, behind_sigma_m, misfit_m;
};

// Least squares of x = (beside, behind, below the camera): at the light's distance, which is the
// carrier's and `behind`, both tangents are those of one place.
BodyPlace place_of(const std::vector<BothSeen>& looks) {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  const auto rows_of = [](const BothSeen& look) {
    Eigen::Matrix<double, 2, 3> slopes;
    slopes << 1.0, -look.across, 0.0, 0.0, -look.down, 1.0;
    return slopes;
  };
  const auto wanted_m = [](const BothSeen& look) -> Eigen::Vector2d {
    return look.carrier_m * Eigen::Vector2d(look.across - look.carrier_across, look.down);
  };
  for (const BothSeen& look : looks) {
    const auto slopes = rows_of(look);
    const double weight = 1.0 / (look.carrier_m * look.carrier_m);
    information += weight * slopes.transpose() * slopes;
    gradient += weight * slopes.transpose() * wanted_m(look);
  }
  const auto solver = information.ldlt();
  const Eigen::Vector3d place_m = solver.solve(gradient);
  double square_m2 = 0.0, square = 0.0;
  for (const BothSeen& look : looks) {
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
  constexpr double kNearer = 1.25, kMisfit_m = 0.1, kMostSigma_m = 0.7;
  constexpr double kLeastBehind_m = 1.0, kLorry_m = 18.0, kCar_m = 5.0, kLorrysPair_m = 1.55;
  constexpr double kLeastBeside = 0.52, kMostBeside = 0.85;  // of the pair's separation
  const auto has_pair = [](const VehicleEstimate& one) {
    return std::ranges::any_of(one.rows, shows_both);
  };
  if (light.trajectories.empty() || carrier.trajectories.empty() || has_pair(light) ||
      light.result.direction != carrier.result.direction)
    return false;
  const std::vector<BothSeen> looks = both_seen(light, carrier);
  if (looks.size() < kFewest) return false;
  const auto [nearest, farthest] = std::ranges::minmax(looks, {}, &BothSeen::carrier_m);
  if (farthest.carrier_m < kNearer * nearest.carrier_m) return false;
  std::vector<double> separations_m;
  for (const BothSeen& look : looks) separations_m.push_back(look.separation_m);
  const double separation_m = median(std::move(separations_m));
  const BodyPlace place = place_of(looks);
  const double beside = std::abs(place.beside_m) / separation_m;
  return place.misfit_m < kMisfit_m && place.behind_sigma_m < kMostSigma_m &&
         place.behind_m > kLeastBehind_m &&
         place.behind_m < (separation_m > kLorrysPair_m ? kLorry_m : kCar_m) &&
         beside > kLeastBeside && beside < kMostBeside;
}

}  // namespace vildar
