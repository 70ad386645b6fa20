#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace vildar {

/// One line of a CSV file (RFC 4180 quoting, line feed at the end). Absent and non-finite numbers
/// give empty cells.
class CsvRow {
 public:
  /// Quoted where it holds a comma, a quote or a line break.
  CsvRow& text(std::string_view cell);
  CsvRow& integer(std::int64_t value);
  CsvRow& fixed(std::optional<double> value, int digits);
  /// `digits` significant digits, for quantities that span decades.
  CsvRow& significant(std::optional<double> value, int digits);
  CsvRow& empty(int cells = 1);
  /// The finished line; the row starts anew with the next cell.
  std::string_view line();

 private:
  void next_cell();

  std::string line_;
  bool finished_ = true;
};

}  // namespace vildar
