#include "track/assignment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/assignment.h"

namespace vildar {

std::vector<std::optional<int>> assign_rows(const Eigen::MatrixXd& cost, double unassigned_cost) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto rows = static_cast<std::size_t>(cost.rows());
  const auto columns = static_cast<std::size_t>(cost.cols());
  if (!std::isfinite(unassigned_cost))
    throw std::invalid_argument("assign_rows: unassigned_cost must be finite");
  if (cost.hasNaN() || (cost.size() > 0 && cost.minCoeff() == -kInfinity))
    throw std::invalid_argument("assign_rows: cost entries must be numbers above -infinity");

  // Column `columns + r` is row r's own way of staying unassigned; with it a full assignment
  // exists, and one forbidden entry outweighs any choice among the others.
  double largest = std::abs(unassigned_cost);
  for (Eigen::Index i = 0; i < cost.size(); ++i)
    if (cost.data()[i] < kInfinity) largest = std::max(largest, std::abs(cost.data()[i]));
  const double forbidden = (largest + 1.0) * (4.0 * static_cast<double>(rows) + 4.0);
  const std::size_t width = columns + rows;
  std::vector<double> square(rows * width, forbidden);
  for (std::size_t r = 0; r < rows; ++r) {
    for (std::size_t c = 0; c < columns; ++c)
      square[r * width + c] =
          std::min(forbidden, cost(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)));
    square[r * width + columns + r] = unassigned_cost;
  }
  std::vector<std::optional<int>> assigned(rows);
  for (const AssignedPair& pair : assign(square, rows, width))
    if (pair.column < columns) assigned[pair.row] = static_cast<int>(pair.column);
  return assigned;
}

}  // namespace vildar
