#include "evaluate/csv_reader.h"

#include <charconv>
#include <cmath>
#include <system_error>

#include "core/error.h"
#include "core/text.h"

namespace vildar {
namespace {

// False where a quote is not closed.
bool split(std::string_view line, std::vector<std::string>& cells) {
  cells.clear();
  std::string cell;
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted) {
      if (c != '"') {
        cell += c;
      } else if (i + 1 < line.size() && line[i + 1] == '"') {
        cell += line[++i];
      } else {
        quoted = false;
      }
    } else if (c == '"') {
      quoted = true;
    } else if (c == ',') {
      cells.push_back(std::move(cell));
      cell.clear();
    } else {
      cell += c;
    }
  }
  cells.push_back(std::move(cell));
  return !quoted;
}

}  // namespace

CsvReader::CsvReader(std::filesystem::path path, const std::vector<std::string_view>& required)
    : path_(std::move(path)), stream_(path_) {
  if (!stream_ || std::filesystem::is_directory(path_))
    throw InputError(path_.string() + ": cannot be opened; give the folder that holds it");
  if (!read_cells())
    throw InputError(path_.string() + ": has no header line; the first line names the columns");
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const auto [name, is_new] = columns_.emplace(trimmed(cells_[i]), i);
    if (!is_new) fail(name->first, "stands twice in the header", "name each column once");
  }
  for (const std::string_view name : required)
    if (!columns_.contains(name)) fail(name, "is missing", "add it to the header and to every row");
}

bool CsvReader::read_cells() {
  std::string line;
  while (std::getline(stream_, line)) {
    ++line_;
    if (line_ == 1 && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
    if (line.ends_with('\r')) line.pop_back();
    if (line.empty() || line.front() == '#') continue;
    if (!split(line, cells_))
      throw InputError(path_.string() + ":" + std::to_string(line_) +
                       ": a quote is not closed; close it on the same line");
    return true;
  }
  if (stream_.bad())
    throw InputError(path_.string() + ":" + std::to_string(line_) +
                     ": reading failed after this line; check the disk");
  return false;
}

bool CsvReader::next() {
  if (!read_cells()) return false;
  if (cells_.size() != columns_.size())
    throw InputError(path_.string() + ":" + std::to_string(line_) + ": has " +
                     std::to_string(cells_.size()) + " cells, the header names " +
                     std::to_string(columns_.size()) + "; the file may have been cut short");
  return true;
}

std::string_view CsvReader::text(std::string_view column) const {
  const auto found = columns_.find(column);
  return found == columns_.end() ? std::string_view() : trimmed(cells_[found->second]);
}

std::string_view CsvReader::required_text(std::string_view column) const {
  const std::string_view cell = text(column);
  if (cell.empty()) fail(column, "is empty", "every row needs it");
  return cell;
}

std::optional<double> CsvReader::optional_number(std::string_view column) const {
  const std::string_view cell = text(column);
  if (cell.empty()) return std::nullopt;
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value))
    fail(column, "\"" + std::string(cell) + "\" is not a finite number",
         "write a decimal number, or leave the cell empty where there is none");
  return value;
}

double CsvReader::number(std::string_view column) const {
  required_text(column);
  return *optional_number(column);
}

std::int64_t CsvReader::integer(std::string_view column) const {
  const std::string_view cell = required_text(column);
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size())
    fail(column, "\"" + std::string(cell) + "\" is not a whole number", "write digits alone");
  return value;
}

void CsvReader::fail(std::string_view column, const std::string& fault,
                     const std::string& remedy) const {
  throw InputError(path_.string() + ":" + std::to_string(line_) + ": column " +
                   std::string(column) + ": " + fault + "; " + remedy);
}

}  // namespace vildar
