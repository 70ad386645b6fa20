#include "estimate/cubic_spline.h"

#include <algorithm>
#include <stdexcept>

namespace vildar {
namespace {

constexpr int kDegree = 3;

}  // namespace

CubicSpline::CubicSpline(const std::vector<double>& breaks) {
  if (breaks.size() < 2 || std::adjacent_find(breaks.begin(), breaks.end(), [](double a, double b) {
                             return !(a < b);
                           }) != breaks.end())
    throw std::invalid_argument("CubicSpline: at least two increasing breaks are needed");
  knots_.assign(kDegree, breaks.front());
  knots_.insert(knots_.end(), breaks.begin(), breaks.end());
  knots_.insert(knots_.end(), kDegree, breaks.back());
}

// De Boor's recurrence, from the one constant piece up to four cubic ones.
CubicSpline::Local CubicSpline::at(double u) const {
  const auto inner = std::upper_bound(knots_.begin() + kDegree + 1, knots_.end() - kDegree - 1, u);
  const auto piece = static_cast<std::size_t>(inner - knots_.begin()) - 1;
  Local local;
  local.first = static_cast<int>(piece) - kDegree;
  std::array<double, 4> value{1.0, 0.0, 0.0, 0.0};
  for (std::size_t degree = 1; degree <= kDegree; ++degree) {
    if (degree == kDegree) {
      // Slopes follow from the values one degree lower.
      for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t i = piece - kDegree + k;
        const double rising = k > 0 ? value[k - 1] / (knots_[i + kDegree] - knots_[i]) : 0.0;
        const double falling = k < 3 ? value[k] / (knots_[i + kDegree + 1] - knots_[i + 1]) : 0.0;
        local.slope[k] = kDegree * (rising - falling);
      }
    }
    double carried = 0.0;
    for (std::size_t k = 0; k < degree; ++k) {
      const double high = knots_[piece + 1 + k], low = knots_[piece + 1 + k - degree];
      const double share = value[k] / (high - low);
      value[k] = carried + (high - u) * share;
      carried = (u - low) * share;
    }
    value[degree] = carried;
  }
  local.value = value;
  return local;
}

}  // namespace vildar
