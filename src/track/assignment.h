#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace vildar {

/// Assignment of rows to columns of least total cost, each column used at most once. A row may stay
/// without a column at `unassigned_cost`; an entry of +infinity is forbidden. Any shape, empty
/// included. Time grows with rows^2 (rows + columns).
/// Throws std::invalid_argument on a NaN or -infinity entry or a non-finite `unassigned_cost`.
std::vector<std::optional<int>> assign_rows(const Eigen::MatrixXd& cost, double unassigned_cost);

}  // namespace vildar
