#include "capture/photodiode_csv.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "capture/csv_header.h"
#include "capture/csv_number.h"
#include "core/error.h"
#include "core/text.h"

namespace vildar {
namespace {

namespace fs = std::filesystem;

/// Blocks of a file. Read, not mapped: a trace that another program cuts meanwhile must not kill
/// us.
class FileReader {
 public:
  explicit FileReader(const fs::path& path)
      : path_(path), descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (descriptor_ < 0)
      throw InputError(path.string() + ": cannot be opened: " + std::strerror(errno) +
                       "; check the name and its permissions");
    struct stat status {};
    if (::fstat(descriptor_, &status) == 0) {
      size_bytes_ = S_ISREG(status.st_mode) ? static_cast<std::size_t>(status.st_size) : 0;
      if (S_ISDIR(status.st_mode)) {
        ::close(descriptor_);
        throw InputError(path.string() + ": is a folder; name the trace inside it");
      }
    }
  }
  ~FileReader() { ::close(descriptor_); }
  FileReader(const FileReader&) = delete;
  FileReader& operator=(const FileReader&) = delete;

  /// Bytes read into `to`; 0 at the end.
  std::size_t read(char* to, std::size_t room) {
    for (;;) {
      const ssize_t count = ::read(descriptor_, to, room);
      if (count >= 0) return static_cast<std::size_t>(count);
      if (errno != EINTR)
        throw InputError(path_.string() + ": cannot be read: " + std::strerror(errno) +
                         "; copy it to a sound disk");
    }
  }
  std::size_t size_bytes() const { return size_bytes_; }  ///< 0 where unknown

 private:
  fs::path path_;
  int descriptor_;
  std::size_t size_bytes_ = 0;
};

struct RejectedRows {
  std::int64_t count = 0;
  long first_line = 0;
};

/// NaN for what no float can hold.
float float_of(double value) {
  return std::abs(value) <= std::numeric_limits<float>::max()
             ? static_cast<float>(value)
             : std::numeric_limits<float>::quiet_NaN();
}

class CsvReader {
 public:
  explicit CsvReader(const fs::path& path) : path_(path), file_(path) {}

  PhotodiodeRecording read();

 private:
  void read_lines(const char* from, const char* to);
  bool read_row_fast(const char*& at, const char* to);
  void read_line(std::string_view line);
  void read_row(std::string_view line);
  void read_last_line(std::string_view line);
  void reject(const std::string& reason);
  void add_row();
  void reserve(std::size_t row_bytes);
  void report();

  const fs::path& path_;
  FileReader file_;
  PhotodiodeRecording recording_;
  std::optional<CsvHeader> header_;
  std::vector<float> row_values_;
  double row_time_s_ = 0.0;
  long line_ = 0;
  std::size_t last_row_bytes_ = 0;  // without its line end
  std::map<std::string, RejectedRows> rejected_;
};

PhotodiodeRecording CsvReader::read() {
  constexpr std::size_t kLeastBlock = std::size_t{1} << 16;
  constexpr std::size_t kLargestBlock = std::size_t{1} << 20;
  const std::size_t block = file_.size_bytes() == 0
                                ? kLargestBlock
                                : std::clamp(file_.size_bytes(), kLeastBlock, kLargestBlock);
  constexpr std::size_t kLongestLine = std::size_t{1} << 24;
  std::vector<char> buffer(2 * block);
  std::size_t kept = 0;
  bool first = true;
  for (;;) {
    if (kept + block > buffer.size()) buffer.resize(2 * buffer.size());
    const std::size_t count = file_.read(buffer.data() + kept, block);
    const char* begin = buffer.data();
    const char* end = begin + kept + count;
    if (std::exchange(first, false)) {
      if (count == 0)
        throw InputError(path_.string() + ": the file is empty; copy it from the logger again");
      const std::string_view start(begin, count);
      if (start.starts_with("\xff\xfe") || start.starts_with("\xfe\xff"))
        throw InputError(path_.string() + ": is UTF-16 text; save it as UTF-8 or plain ASCII");
      if (start.starts_with("\xef\xbb\xbf")) begin += 3;
    }
    if (count == 0) {
      if (kept > 0) read_last_line({begin, end});
      break;
    }
    const auto* last_newline =
        static_cast<const char*>(::memrchr(begin, '\n', static_cast<std::size_t>(end - begin)));
    const char* whole = last_newline != nullptr ? last_newline + 1 : begin;
    if (!header_ && std::memchr(begin, '\0', static_cast<std::size_t>(whole - begin)) != nullptr)
      throw InputError(path_.string() +
                       ": holds binary data; a photodiode trace is a CSV text file");
    read_lines(begin, whole);
    kept = static_cast<std::size_t>(end - whole);
    if (kept > kLongestLine)
      throw InputError(path_.string() + ":" + std::to_string(line_ + 1) + ": a line of more than " +
                       std::to_string(kLongestLine >> 20) +
                       " MiB; a photodiode trace is a CSV text file");
    std::memmove(buffer.data(), whole, kept);
  }
  report();
  return std::move(recording_);
}

/// Lines between `from` and `to`, the last one ended by a newline.
void CsvReader::read_lines(const char* from, const char* to) {
  const char* at = from;
  while (at < to) {
    const char* start = at;
    ++line_;
    if (header_ && read_row_fast(at, to)) {
      last_row_bytes_ = static_cast<std::size_t>(at - start) - (at[-2] == '\r' ? 2 : 1);
      add_row();
      continue;
    }
    const auto* end =
        static_cast<const char*>(std::memchr(start, '\n', static_cast<std::size_t>(to - start)));
    read_line({start, end});
    at = end + 1;
  }
}

/// A row of finite numbers in every column; false, with nothing taken, for all that is not so
/// simple.
bool CsvReader::read_row_fast(const char*& at, const char* to) {
  const char* cell = at;
  for (std::size_t column = 0; column < header_->roles.size(); ++column) {
    if (column > 0 && *cell++ != ',') return false;
    while (*cell == ' ') ++cell;
    double value = 0.0;
    if (const char* start = cell; !read_plain_number(cell, value)) {
      const auto [end, error] = std::from_chars(start, to, value);
      if (error != std::errc() || !(std::abs(value) < std::numeric_limits<float>::max()))
        return false;
      cell = end;
    }
    const int role = header_->roles[column];
    if (role >= 0)
      row_values_[static_cast<std::size_t>(role)] = static_cast<float>(value);
    else if (role == CsvHeader::kTime)
      row_time_s_ = value;
  }
  if (*cell == '\r') ++cell;
  if (*cell != '\n') return false;
  at = cell + 1;
  return true;
}

void CsvReader::read_line(std::string_view line) {
  const std::string_view text = trimmed(line);
  if (text.empty() || text.front() == '#') return;
  if (header_) {
    last_row_bytes_ = line.size() - (line.ends_with('\r') ? 1 : 0);
    read_row(line);
    return;
  }
  header_ = read_csv_header(text, path_, line_);
  recording_.quantity = header_->quantity;
  recording_.ids = header_->ids;
  recording_.values.resize(header_->ids.size());
  row_values_.resize(header_->ids.size());
  for (const std::string& name : header_->ignored)
    recording_.warnings.push_back(path_.string() + ":" + std::to_string(line_) + ": column \"" +
                                  name + "\" is not known; left out");
}

void CsvReader::read_row(std::string_view line) {
  const std::vector<std::string_view> cells = cells_of(line);
  if (cells.size() != header_->roles.size()) return reject("wrong_cell_count");
  for (std::size_t column = 0; column < cells.size(); ++column) {
    const int role = header_->roles[column];
    if (role == CsvHeader::kIgnored) continue;
    const std::optional<double> value = number_in_cell(cells[column]);
    if (role == CsvHeader::kTime) {
      if (!value || std::isnan(*value)) return reject("unreadable_time");
      row_time_s_ = *value;
    } else {
      if (!value) return reject("unreadable_value");
      row_values_[static_cast<std::size_t>(role)] = float_of(*value);
    }
  }
  add_row();
}

/// What follows the last newline. A logger that was switched off leaves half a row, whose last
/// number may look whole.
void CsvReader::read_last_line(std::string_view line) {
  ++line_;
  const std::string_view text = trimmed(line);
  if (header_ && !text.empty() && text.front() != '#' && line.size() < last_row_bytes_)
    return reject("cut_off_last_row");
  read_line(line);
}

void CsvReader::reject(const std::string& reason) {
  RejectedRows& rows = rejected_[reason];
  if (rows.count++ == 0) rows.first_line = line_;
}

void CsvReader::add_row() {
  constexpr double kFarthest_s = 1e10;  // 317 years; beyond, a double no longer holds microseconds
  if (!(std::abs(row_time_s_) <= kFarthest_s)) return reject("unreadable_time");
  if (recording_.time_s.empty()) reserve(last_row_bytes_ + 1);
  recording_.time_s.push_back(row_time_s_);
  for (std::size_t channel = 0; channel < row_values_.size(); ++channel)
    recording_.values[channel].push_back(row_values_[channel]);
}

void CsvReader::reserve(std::size_t row_bytes) {
  const std::size_t rows = file_.size_bytes() / row_bytes + 1;
  recording_.time_s.reserve(rows);
  for (std::vector<float>& channel : recording_.values) channel.reserve(rows);
}

void CsvReader::report() {
  if (!header_)
    throw InputError(path_.string() + ": no header line; expected for instance \"t_s,power_w\"");
  recording_.rows_read = static_cast<std::int64_t>(recording_.time_s.size());
  std::string reasons;
  for (const auto& [reason, rows] : rejected_) {
    recording_.rejected[reason] = rows.count;
    recording_.damaged = true;
    recording_.warnings.push_back(path_.string() + ":" + std::to_string(rows.first_line) + ": " +
                                  reason + ", the first of " + std::to_string(rows.count) +
                                  " rows; left out; correct or delete them");
    reasons +=
        (reasons.empty() ? " (" : ", ") + reason + " from line " + std::to_string(rows.first_line);
  }
  if (!reasons.empty()) reasons += ")";
  if (recording_.rows_read == 0)
    throw InputError(path_.string() + ": no row that can be read after the header" + reasons +
                     "; copy it from the logger again");
}

}  // namespace

PhotodiodeRecording read_photodiode_csv(const fs::path& path) { return CsvReader(path).read(); }

}  // namespace vildar
