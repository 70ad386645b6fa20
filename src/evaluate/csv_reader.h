#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vildar {

/// A CSV file with one header line, read row by row; columns are found by name, in any order, and
/// those not asked for are ignored. Lines that begin with `#` and blank lines are skipped; a cell
/// may be quoted (RFC 4180, without line breaks inside). Every fault throws InputError naming file,
/// line, column and remedy.
class CsvReader {
 public:
  /// Reads the header; a file that cannot be opened, has no header, or lacks one of `required` is a
  /// fault.
  CsvReader(std::filesystem::path path, const std::vector<std::string_view>& required);

  /// Goes to the next row; false at the end of the file.
  bool next();

  /// Of the present row; a column that the file does not have reads as empty.
  std::string_view text(std::string_view column) const;
  std::optional<double> optional_number(std::string_view column) const;
  /// These fault on an empty cell.
  std::string_view required_text(std::string_view column) const;
  double number(std::string_view column) const;
  std::int64_t integer(std::string_view column) const;

  /// Throws InputError about a cell of the present row.
  [[noreturn]] void fail(std::string_view column, const std::string& fault,
                         const std::string& remedy) const;

 private:
  bool read_cells();

  std::filesystem::path path_;
  std::ifstream stream_;
  int line_ = 0;
  std::map<std::string, std::size_t, std::less<>> columns_;
  std::vector<std::string> cells_;
};

}  // namespace vildar
