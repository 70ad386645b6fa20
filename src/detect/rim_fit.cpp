#include "detect/rim_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/quantity.h"

namespace vildar {
namespace {

constexpr int kRays = 48;
constexpr std::size_t kLeastRays = 16;
constexpr double kStep_px = 0.5;
constexpr double kMostReach_px = 100.0;
constexpr double kTowardsHidden = 0.1;  // cosine from which a ray heads into a neighbour
constexpr double kMostMisfitShare = 0.15;
constexpr double kRounding_px = 0.3;  // scatter of a rim that falls between pixels

/// Where the ray from `start_px` leaves the clipped area, as an offset from there.
std::optional<Eigen::Vector2d> rim_along(const LumaView& luma, int clip_code,
                                         const Eigen::Vector2d& start_px,
                                         const Eigen::Vector2d& direction) {
  for (double reach_px = kStep_px; reach_px < kMostReach_px; reach_px += kStep_px) {
    const Eigen::Vector2d at = start_px + reach_px * direction;
    const int u = static_cast<int>(std::lround(at.x())), v = static_cast<int>(std::lround(at.y()));
    if (u < 0 || v < 0 || u >= luma.width_px || v >= luma.height_px) return std::nullopt;
    if (luma.code(u, v) < clip_code) return (reach_px - 0.5 * kStep_px) * direction;
  }
  return std::nullopt;
}

}  // namespace

std::optional<RimCircle> fit_rim(const LumaView& luma, int clip_code,
                                 const Eigen::Vector2d& start_px,
                                 std::span<const Eigen::Vector2d> hidden) {
  std::vector<Eigen::Vector2d> rim;
  for (int ray = 0; ray < kRays; ++ray) {
    const double angle_rad = 2.0 * kPi * ray / kRays;
    const Eigen::Vector2d direction(std::cos(angle_rad), std::sin(angle_rad));
    const auto into = [&](const Eigen::Vector2d& other) {
      return direction.dot(other) > kTowardsHidden;
    };
    if (std::any_of(hidden.begin(), hidden.end(), into)) continue;
    if (const auto offset = rim_along(luma, clip_code, start_px, direction)) rim.push_back(*offset);
  }
  if (rim.size() < kLeastRays) return std::nullopt;

  // Kasa 1976: x^2 + y^2 = 2 a x + 2 b y + c is linear in centre (a, b) and c = r^2 - a^2 - b^2.
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Eigen::Vector2d& offset : rim) {
    const Eigen::Vector3d row(2.0 * offset.x(), 2.0 * offset.y(), 1.0);
    normal += row * row.transpose();
    right += offset.squaredNorm() * row;
  }
  const Eigen::LDLT<Eigen::Matrix3d> solver(normal);
  const Eigen::Vector3d solved = solver.solve(right);
  const Eigen::Vector2d centre = solved.head<2>();
  const double radius_px = std::sqrt(std::max(solved[2] + centre.squaredNorm(), 0.0));
  double misfit = 0.0;
  for (const Eigen::Vector2d& offset : rim)
    misfit += std::pow((offset - centre).norm() - radius_px, 2);
  const double misfit_px = std::sqrt(misfit / static_cast<double>(rim.size()));
  if (!(misfit_px <= kMostMisfitShare * radius_px) || centre.norm() > radius_px)
    return std::nullopt;

  // The equation's residual is 2 r times the distance to the circle.
  const double residual_px2 = 2.0 * radius_px * std::hypot(misfit_px, kRounding_px);
  const Eigen::Matrix3d inverse = solver.solve(Eigen::Matrix3d::Identity());
  const double variance = inverse.topLeftCorner<2, 2>().diagonal().maxCoeff();
  return RimCircle{start_px + centre, radius_px, residual_px2 * std::sqrt(variance)};
}

}  // namespace vildar
