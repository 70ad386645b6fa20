#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace vildar {

struct AssignedPair {
  std::size_t row = 0;
  std::size_t column = 0;
  friend bool operator==(const AssignedPair&, const AssignedPair&) = default;
};

/// One-to-one assignment of least total cost between `rows` and `columns` things: min(rows,
/// columns) pairs, in order of row. `cost` is row-major, rows * columns finite numbers of either
/// sign; to maximise a score pass its negative. Gates are the caller's: give a forbidden pair a
/// cost so high that it is chosen last, and drop it afterwards. Throws std::invalid_argument for a
/// wrong size or a cost that is not finite. Time grows with min(rows, columns)^2 * max(rows,
/// columns).
std::vector<AssignedPair> assign(std::span<const double> cost, std::size_t rows,
                                 std::size_t columns);

}  // namespace vildar
