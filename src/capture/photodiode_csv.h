#pragma once

#include <filesystem>

#include "types/power.h"

namespace vildar {

/// Reads a photodiode trace: `#` comments, one header line, columns in any order: `t_s` and one of
/// `power_w`, `current_a`, `voltage_v`, `counts`, or several columns of one such quantity named
/// `ID_power_w` and so on. CRLF and a byte-order mark are accepted; other columns are left out with
/// a warning.
///
/// Times and values are as written, in file order. An empty, NaN or infinite value is kept as NaN.
/// Rows that cannot be read are left out, counted by reason (`wrong_cell_count`, `unreadable_time`:
/// also beyond 1e10 s, `unreadable_value`, `cut_off_last_row`) and set `damaged`; a last row
/// without a line end counts as cut off where it is shorter than the row before it. Throws
/// InputError where the file cannot be opened, has no usable header, or holds no row that can be
/// read.
PhotodiodeRecording read_photodiode_csv(const std::filesystem::path& path);

}  // namespace vildar
