#include "track/light_place.h"

#include <array>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

namespace vildar {

std::optional<ExpectedView> expected_view(const PassedView& view, const LightPlace& place) {
  constexpr double kNearest = 0.02;  // of the distance at the reference time
  const Eigen::Vector3d ray =
      view.turned * Eigen::Vector3d(place.x(), place.y(), 1.0) + place.z() * view.moved_m;
  if (!(ray.z() > kNearest)) return std::nullopt;
  ExpectedView found;
  found.at = ray.hnormalized();
  Eigen::Matrix<double, 2, 3> by_ray;
  by_ray << 1.0, 0.0, -found.at.x(), 0.0, 1.0, -found.at.y();
  Eigen::Matrix3d ray_by_place;
  ray_by_place << view.turned.col(0), view.turned.col(1), view.moved_m;
  found.by_place = by_ray * ray_by_place / ray.z();
  return found;
}

// Gauss-Newton from several distances: far lights hardly move, near ones sweep across the picture.
LightPlace first_place(std::span<const PassedView> views, const Eigen::Vector2d& reference,
                       double sigma) {
  constexpr std::array<double, 5> kInverse_per_m{0.0, 1.0 / 150, 1.0 / 60, 1.0 / 30, 1.0 / 15};
  constexpr int kSteps = 5;
  const double weight = 1.0 / (sigma * sigma);
  constexpr double kPrior = 1.0 / (kInverseDistance_per_m * kInverseDistance_per_m);
  double least = INFINITY;
  LightPlace best(reference.x(), reference.y(), 0.0);
  for (const double inverse_per_m : kInverse_per_m) {
    LightPlace place(reference.x(), reference.y(), inverse_per_m);
    for (int i = 0; i <= kSteps; ++i) {
      Eigen::Matrix3d information = Eigen::Vector3d(0.0, 0.0, kPrior).asDiagonal();
      Eigen::Vector3d right(0.0, 0.0, -place.z() * kPrior);
      double cost = place.z() * place.z() * kPrior;
      for (const PassedView& view : views) {
        const auto expected = expected_view(view, place);
        if (!expected) {
          cost = INFINITY;
          break;
        }
        const Eigen::Vector2d off = view.at - expected->at;
        information += weight * expected->by_place.transpose() * expected->by_place;
        right += weight * expected->by_place.transpose() * off;
        cost += weight * off.squaredNorm();
      }
      if (!std::isfinite(cost)) break;
      if (cost < least) {
        least = cost;
        best = place;
      }
      place += information.ldlt().solve(right);
    }
  }
  return best;
}

}  // namespace vildar
