#include "capture/csv_header.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "capture/csv_number.h"
#include "core/error.h"
#include "core/text.h"

namespace vildar {
namespace {

constexpr std::array<std::pair<std::string_view, PowerQuantity>, 4> kQuantities{{
    {"power_w", PowerQuantity::power_w},
    {"current_a", PowerQuantity::current_a},
    {"voltage_v", PowerQuantity::voltage_v},
    {"counts", PowerQuantity::counts},
}};

struct Channel {
  std::string id;
  PowerQuantity quantity;
};

/// `power_w` or `ID_power_w`.
std::optional<Channel> channel_in(std::string_view name) {
  for (const auto& [quantity_name, quantity] : kQuantities) {
    if (name == quantity_name) return Channel{"", quantity};
    if (!name.ends_with(quantity_name)) continue;
    const std::string_view prefix = name.substr(0, name.size() - quantity_name.size());
    if (prefix.size() >= 2 && prefix.back() == '_')
      return Channel{std::string(prefix.substr(0, prefix.size() - 1)), quantity};
  }
  return std::nullopt;
}

std::string_view unquoted(std::string_view cell) {
  cell = trimmed(cell);
  if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"')
    cell = cell.substr(1, cell.size() - 2);
  return trimmed(cell);
}

}  // namespace

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  for (;;) {
    const std::size_t comma = line.find(',');
    cells.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

CsvHeader read_csv_header(std::string_view line, const std::filesystem::path& path,
                          long line_number) {
  const auto fail = [&](const std::string& fault) -> InputError {
    constexpr std::size_t kShown = 80;
    return InputError(
        path.string() + ":" + std::to_string(line_number) + ": " + fault + " in \"" +
        std::string(trimmed(line).substr(0, kShown)) +
        "\"; expected a header such as \"t_s,power_w\" (or current_a, voltage_v, counts), "
        "or with several photodiodes \"t_s,pd0_power_w,pd1_power_w\"");
  };
  CsvHeader header;
  bool has_time = false;
  std::optional<PowerQuantity> quantity;
  for (const std::string_view cell : cells_of(line)) {
    const std::string_view name = unquoted(cell);
    if (name == "t_s") {
      if (std::exchange(has_time, true)) throw fail("t_s stands twice");
      header.roles.push_back(CsvHeader::kTime);
      continue;
    }
    const std::optional<Channel> channel = channel_in(name);
    if (!channel) {
      header.roles.push_back(CsvHeader::kIgnored);
      header.ignored.emplace_back(name);
      continue;
    }
    if (quantity && *quantity != channel->quantity)
      throw fail("columns of different quantities stand together");
    if (std::find(header.ids.begin(), header.ids.end(), channel->id) != header.ids.end())
      throw fail("column " + std::string(name) + " stands twice");
    quantity = channel->quantity;
    header.roles.push_back(static_cast<int>(header.ids.size()));
    header.ids.push_back(channel->id);
  }
  if (!has_time && !quantity && line.find_first_of(";\t") != std::string_view::npos)
    throw fail("columns that no commas part (a point is the decimal sign)");
  if (!has_time && !quantity) throw fail("no header of a photodiode trace");
  if (!has_time) throw fail("no column t_s");
  if (!quantity) throw fail("no column of power, current, voltage or counts");
  if (header.ids.size() > 1 &&
      std::find(header.ids.begin(), header.ids.end(), "") != header.ids.end())
    throw fail("of several columns one names no photodiode");
  header.quantity = *quantity;
  return header;
}

}  // namespace vildar
