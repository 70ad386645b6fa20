#include "track/assignment.h"

#include <cmath>
#include <limits>
#include <stdexcept>

namespace vildar {

std::vector<std::optional<int>> assign_rows(const Eigen::MatrixXd& cost, double unassigned_cost) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const int rows = static_cast<int>(cost.rows());
  const int columns = static_cast<int>(cost.cols());
  if (!std::isfinite(unassigned_cost))
    throw std::invalid_argument("assign_rows: unassigned_cost must be finite");
  if (cost.hasNaN() || (cost.size() > 0 && cost.minCoeff() == -kInfinity))
    throw std::invalid_argument("assign_rows: cost entries must be numbers above -infinity");

  // Column `columns + r` is row r's private way of staying unassigned, so a full matching exists.
  const int width = columns + rows;
  const auto entry = [&](int row, int column) {
    if (column < columns) return cost(row, column);
    return column - columns == row ? unassigned_cost : kInfinity;
  };
  constexpr int kFree = -1;
  std::vector<int> row_of(width, kFree), column_of(rows, kFree), reached_from(width);
  std::vector<double> row_dual(rows, 0.0), column_dual(width, 0.0), distance(width);
  std::vector<char> done(width);

  for (int start = 0; start < rows; ++start) {
    std::fill(distance.begin(), distance.end(), kInfinity);
    std::fill(done.begin(), done.end(), 0);
    int row = start, sink = kFree;
    double least = 0.0;
    while (sink == kFree) {
      int next = kFree;
      for (int column = 0; column < width; ++column) {
        if (done[column]) continue;
        const double through = least + entry(row, column) - row_dual[row] - column_dual[column];
        if (through < distance[column]) {
          distance[column] = through;
          reached_from[column] = row;
        }
        if (next == kFree || distance[column] < distance[next]) next = column;
      }
      least = distance[next];
      done[next] = 1;
      if (row_of[next] == kFree)
        sink = next;
      else
        row = row_of[next];
    }
    row_dual[start] += least;
    for (int column = 0; column < width; ++column) {
      if (!done[column] || column == sink) continue;
      row_dual[row_of[column]] += least - distance[column];
      column_dual[column] -= least - distance[column];
    }
    for (int column = sink;;) {
      const int from = reached_from[column];
      row_of[column] = from;
      std::swap(column_of[from], column);
      if (from == start) break;
    }
  }

  std::vector<std::optional<int>> assigned(rows);
  for (int row = 0; row < rows; ++row)
    if (column_of[row] < columns) assigned[row] = column_of[row];
  return assigned;
}

}  // namespace vildar
