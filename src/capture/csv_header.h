#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "types/power.h"

namespace vildar {

/// What each column of a photodiode trace is.
struct CsvHeader {
  static constexpr int kTime = -1;
  static constexpr int kIgnored = -2;

  std::vector<int> roles;  ///< of each column: its channel from 0, kTime or kIgnored
  std::vector<std::string> ids;
  PowerQuantity quantity = PowerQuantity::power_w;
  std::vector<std::string> ignored;  ///< names of the columns left out
};

/// Throws InputError, showing the header that is expected, where there is no `t_s`, no or more than
/// one quantity, or a channel twice.
CsvHeader read_csv_header(std::string_view line, const std::filesystem::path& path,
                          long line_number);

/// The cells of a line, blanks kept.
std::vector<std::string_view> cells_of(std::string_view line);

}  // namespace vildar
