#include "optics/candela_table.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/quantity.h"

namespace vildar {
namespace {

/// Rounding of angles that were converted from degrees.
constexpr double kAngleSlack_rad = 1e-9;

/// Cell that holds an angle, and how far through it.
struct Place {
  std::size_t low = 0, high = 0;
  double share = 0.0;
};

std::optional<Place> place_in(const std::vector<double>& angles_rad, double angle_rad) {
  if (angles_rad.size() == 1) return Place{};
  if (!(angle_rad >= angles_rad.front() - kAngleSlack_rad) ||
      angle_rad > angles_rad.back() + kAngleSlack_rad)
    return std::nullopt;
  const auto above = std::upper_bound(angles_rad.begin() + 1, angles_rad.end() - 1, angle_rad);
  const auto high = static_cast<std::size_t>(above - angles_rad.begin());
  const double low_rad = angles_rad[high - 1];
  return Place{high - 1, high,
               std::clamp((angle_rad - low_rad) / (angles_rad[high] - low_rad), 0.0, 1.0)};
}

void check_increasing(const std::vector<double>& angles_rad, const char* which) {
  if (angles_rad.empty() || std::adjacent_find(angles_rad.begin(), angles_rad.end(),
                                               std::greater_equal<>()) != angles_rad.end())
    throw std::invalid_argument(std::string("candela table: ") + which +
                                " angles must be present and increase");
}

/// The horizontal angle on the measured side of the symmetry.
double folded(const CandelaGrid& grid, double horizontal_rad) {
  if (grid.type != PhotometricType::c)
    return grid.symmetry == TableSymmetry::none ? horizontal_rad : std::abs(horizontal_rad);
  double angle_rad = std::fmod(horizontal_rad, 2.0 * kPi);
  if (angle_rad < 0.0) angle_rad += 2.0 * kPi;
  switch (grid.symmetry) {
    case TableSymmetry::none: return angle_rad;
    case TableSymmetry::rotational: return 0.0;
    case TableSymmetry::bilateral: return std::min(angle_rad, 2.0 * kPi - angle_rad);
    case TableSymmetry::quadrant: {
      const double half_rad = std::min(angle_rad, 2.0 * kPi - angle_rad);
      return std::min(half_rad, kPi - half_rad);
    }
    case TableSymmetry::bilateral_side:
      if (angle_rad < 0.5 * kPi) return kPi - angle_rad;
      return angle_rad > 1.5 * kPi ? 3.0 * kPi - angle_rad : angle_rad;
  }
  return angle_rad;
}

/// Integrals over [low, high] of the two linear weights (1 at low, 1 at high) times f, where
/// `f_integral` is f's antiderivative F and `second` that of F.
struct Weights {
  double low = 0.0, high = 0.0;
};
template <class First, class Second>
Weights linear_weights(double low_rad, double high_rad, First first, Second second) {
  const double width_rad = high_rad - low_rad;
  const double mean = (second(high_rad) - second(low_rad)) / width_rad;
  return {mean - first(low_rad), first(high_rad) - mean};
}

}  // namespace

CandelaTable::CandelaTable(CandelaGrid grid) : grid_(std::move(grid)) {
  check_increasing(grid_.vertical_rad, "vertical");
  check_increasing(grid_.horizontal_rad, "horizontal");
  if (grid_.vertical_rad.size() < 2)
    throw std::invalid_argument("candela table: needs two vertical angles or more");
  if (grid_.intensity_cd.size() != grid_.vertical_rad.size() * grid_.horizontal_rad.size())
    throw std::invalid_argument("candela table: intensities do not fill the grid");
  if ((grid_.horizontal_rad.size() == 1) != (grid_.symmetry == TableSymmetry::rotational))
    throw std::invalid_argument("candela table: one horizontal angle means rotational symmetry");
}

double CandelaTable::intensity_cd(double horizontal_rad, double vertical_rad) const {
  const auto across = place_in(grid_.horizontal_rad, folded(grid_, horizontal_rad));
  const auto up = place_in(grid_.vertical_rad,
                           grid_.mirrored_vertically ? std::abs(vertical_rad) : vertical_rad);
  if (!across || !up) return 0.0;
  const double low_cd = std::lerp(at(across->low, up->low), at(across->low, up->high), up->share);
  const double high_cd =
      std::lerp(at(across->high, up->low), at(across->high, up->high), up->share);
  return std::lerp(low_cd, high_cd, across->share);
}

double CandelaTable::flux_lm() const {
  // The solid angle is |sin| (C), cos(horizontal) (B) or cos(vertical) (A) per square radian.
  const auto flat = [](double low_rad, double high_rad) {
    return Weights{0.5 * (high_rad - low_rad), 0.5 * (high_rad - low_rad)};
  };
  const auto cosine = [](double low_rad, double high_rad) {
    return linear_weights(
        low_rad, high_rad, [](double x) { return std::sin(x); },
        [](double x) { return -std::cos(x); });
  };
  const auto sine = [](double low_rad, double high_rad) {
    return linear_weights(
        low_rad, high_rad, [](double x) { return -std::cos(x); },
        [](double x) { return -std::sin(x); });
  };
  const auto& vertical_rad = grid_.vertical_rad;
  const auto& horizontal_rad = grid_.horizontal_rad;
  double flux_lm = 0.0;
  const bool rotational = grid_.symmetry == TableSymmetry::rotational;
  for (std::size_t h = 0; h + 1 < horizontal_rad.size() || (rotational && h == 0); ++h) {
    const std::size_t next = rotational ? h : h + 1;
    const Weights across = rotational ? Weights{kPi, kPi}
                           : grid_.type == PhotometricType::b
                               ? cosine(horizontal_rad[h], horizontal_rad[next])
                               : flat(horizontal_rad[h], horizontal_rad[next]);
    for (std::size_t v = 0; v + 1 < vertical_rad.size(); ++v) {
      const Weights up =
          grid_.type == PhotometricType::c   ? sine(vertical_rad[v], vertical_rad[v + 1])
          : grid_.type == PhotometricType::a ? cosine(vertical_rad[v], vertical_rad[v + 1])
                                             : flat(vertical_rad[v], vertical_rad[v + 1]);
      flux_lm += across.low * (up.low * at(h, v) + up.high * at(h, v + 1)) +
                 across.high * (up.low * at(next, v) + up.high * at(next, v + 1));
    }
  }
  if (grid_.symmetry == TableSymmetry::quadrant) flux_lm *= 4.0;
  if (grid_.symmetry == TableSymmetry::bilateral || grid_.symmetry == TableSymmetry::bilateral_side)
    flux_lm *= 2.0;
  if (grid_.mirrored_vertically) flux_lm *= 2.0;
  return flux_lm;
}

double TableBeam::intensity_cd(double azimuth_rad, double elevation_rad) const {
  const double ahead = std::cos(elevation_rad) * std::cos(azimuth_rad);
  const double left = std::cos(elevation_rad) * std::sin(azimuth_rad);
  const double up = std::sin(elevation_rad);
  switch (table->type()) {
    case PhotometricType::a: return table->intensity_cd(-azimuth_rad, elevation_rad);
    case PhotometricType::b:
      return table->intensity_cd(std::asin(std::clamp(-left, -1.0, 1.0)), std::atan2(up, ahead));
    case PhotometricType::c: break;
  }
  if (type_c_axis == TypeCAxis::down)
    return table->intensity_cd(azimuth_rad, elevation_rad + 0.5 * kPi);
  return table->intensity_cd(std::atan2(left, up), std::atan2(std::hypot(left, up), ahead));
}

}  // namespace vildar
