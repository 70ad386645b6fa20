#include "capture/csv_number.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/text.h"

namespace vildar {

std::optional<double> number_in_cell(std::string_view cell) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  cell = trimmed(cell);
  if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"')
    cell = trimmed(cell.substr(1, cell.size() - 2));
  if (cell.size() >= 2 && cell.front() == '+' && cell[1] != '-') cell.remove_prefix(1);
  if (cell.empty()) return kNan;
  std::string lower(cell.substr(0, 4));
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
  if (lower == "null" || lower == "n/a" || lower == "na") return kNan;
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (end != cell.data() + cell.size() || error == std::errc::invalid_argument) return std::nullopt;
  if (error == std::errc::result_out_of_range) return kNan;
  return std::isfinite(value) ? value : kNan;
}

}  // namespace vildar
