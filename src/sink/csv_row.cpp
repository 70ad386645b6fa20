#include "sink/csv_row.h"

#include <array>
#include <charconv>
#include <cmath>

#include "core/text.h"

namespace vildar {

void CsvRow::next_cell() {
  if (finished_) {
    line_.clear();
    finished_ = false;
  } else {
    line_ += ',';
  }
}

CsvRow& CsvRow::text(std::string_view cell) {
  next_cell();
  if (cell.find_first_of(",\"\r\n") == std::string_view::npos) {
    line_ += cell;
    return *this;
  }
  line_ += '"';
  for (const char letter : cell) {
    if (letter == '"') line_ += '"';
    line_ += letter;
  }
  line_ += '"';
  return *this;
}

CsvRow& CsvRow::integer(std::int64_t value) {
  next_cell();
  line_ += std::to_string(value);
  return *this;
}

CsvRow& CsvRow::fixed(std::optional<double> value, int digits) {
  next_cell();
  if (value) line_ += fixed_text(*value, digits);
  return *this;
}

CsvRow& CsvRow::significant(std::optional<double> value, int digits) {
  next_cell();
  if (!value || !std::isfinite(*value)) return *this;
  std::array<char, 64> buffer;
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), *value,
                                    std::chars_format::general, digits);
  line_.append(buffer.data(), result.ptr);
  return *this;
}

CsvRow& CsvRow::empty(int cells) {
  for (int i = 0; i < cells; ++i) next_cell();
  return *this;
}

std::string_view CsvRow::line() {
  line_ += '\n';
  finished_ = true;
  return line_;
}

}  // namespace vildar
