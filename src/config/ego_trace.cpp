#include "config/ego_trace.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "core/text.h"

namespace vildar {
namespace {

namespace fs = std::filesystem;

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t comma; (comma = line.find(',')) != std::string_view::npos;
       line.remove_prefix(comma + 1))
    cells.push_back(trimmed(line.substr(0, comma)));
  cells.push_back(trimmed(line));
  return cells;
}

std::optional<double> finite_number(std::string_view cell) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value))
    return std::nullopt;
  return value;
}

constexpr std::array<std::string_view, 3> kColumns{"t_s", "speed_mps", "yaw_rate_rad_per_s"};

class TraceReader {
 public:
  TraceReader(const fs::path& file, std::vector<Problem>& problems)
      : file_(file.string()), problems_(problems) {}

  std::vector<EgoSample> samples;

  /// False where reading on is of no use.
  bool take(std::string_view line, int number) {
    if (number == 1 && line.starts_with("\xEF\xBB\xBF")) line.remove_prefix(3);
    line = trimmed(line);
    if (line.empty() || line.front() == '#') return true;
    const std::vector<std::string_view> cells = cells_of(line);
    if (columns_ == 0) return take_header(cells, number);
    constexpr int kMostFaults = 10;
    if (!take_row(cells, number)) ++faults_;
    return faults_ < kMostFaults;
  }

  void end() {
    if (columns_ == 0)
      problem(0, "", "has no header line", "begin with t_s,speed_mps");
    else if (samples.empty() && faults_ == 0)
      problem(0, "", "has no samples", "give at least one line of numbers under the header");
    else
      judge();
  }

  void problem(int line, std::string_view column, std::string fault, std::string remedy) {
    problems_.push_back({file_, line, std::string(column), std::move(fault), std::move(remedy)});
  }

 private:
  bool take_header(const std::vector<std::string_view>& cells, int number) {
    bool known = cells.size() == 2 || cells.size() == 3;
    for (std::size_t i = 0; known && i < cells.size(); ++i) known = cells[i] == kColumns[i];
    columns_ = cells.size();
    if (known) return true;
    ++faults_;
    problem(number, "", "the header is not that of an ego trace",
            "write t_s,speed_mps or t_s,speed_mps,yaw_rate_rad_per_s");
    return false;
  }

  bool take_row(const std::vector<std::string_view>& cells, int number) {
    if (cells.size() != columns_) {
      problem(number, "", "has " + std::to_string(cells.size()) + " columns",
              "give " + std::to_string(columns_) + ", as the header says");
      return false;
    }
    std::array<double, 3> values{};
    for (std::size_t i = 0; i < columns_; ++i) {
      const std::optional<double> value = finite_number(cells[i]);
      if (!value) {
        problem(number, kColumns[i],
                "\"" + std::string(cells[i].substr(0, 40)) + "\" is not a finite number",
                "mend or remove the line");
        return false;
      }
      values[i] = *value;
    }
    constexpr double kMost_mps = 100.0, kStands_mps = 0.3;  // noise of one that stands
    if (values[1] < -kStands_mps || values[1] > kMost_mps) {
      problem(
          number, kColumns[1], number_text(values[1]) + " is out of range",
          "must be metres per second, from -0.3 (one that stands) to " + number_text(kMost_mps));
      return false;
    }
    values[1] = std::max(0.0, values[1]);
    if (!samples.empty() && !(values[0] > samples.back().time_s)) {
      problem(number, kColumns[0],
              number_text(values[0]) + " does not come after " + number_text(samples.back().time_s),
              "put the lines in order of time, each time once");
      return false;
    }
    samples.push_back({values[0], values[1], values[2]});
    lines_.push_back(number);
    return true;
  }

  // What no vehicle drives has other units, or samples that are wrong: no two samples may be
  // further apart in speed than tyres change it between them.
  void judge() {
    constexpr double kNoise_mps = 2.0, kGrip_mps2 = 9.8, kMostTurn_mps2 = 15.0;
    double slowest_mps = INFINITY, fastest_mps = -INFINITY;  // that it can have by now
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const auto& [time_s, speed_mps, yaw_rate_rad_per_s] = samples[i];
      if (i > 0) {
        const double more_mps = kGrip_mps2 * (time_s - samples[i - 1].time_s);
        fastest_mps += more_mps;
        slowest_mps -= more_mps;
        if (speed_mps > fastest_mps + kNoise_mps || speed_mps < slowest_mps - kNoise_mps) {
          problem(lines_[i], kColumns[1],
                  number_text(speed_mps) + " m/s is further from the speeds before than tyres give",
                  "give metres per second, not km/h; remove samples that are wrong");
          return;
        }
      }
      fastest_mps = i > 0 ? std::min(fastest_mps, speed_mps) : speed_mps;
      slowest_mps = i > 0 ? std::max(slowest_mps, speed_mps) : speed_mps;
      if (std::abs(speed_mps * yaw_rate_rad_per_s) > kMostTurn_mps2) {
        problem(lines_[i], kColumns[2],
                "turning by " + number_text(yaw_rate_rad_per_s) + " rad/s at " +
                    number_text(speed_mps) + " m/s is more than tyres give",
                "give radians per second, not degrees; remove samples that are wrong");
        return;
      }
    }
  }

  std::string file_;
  std::vector<Problem>& problems_;
  std::vector<int> lines_;  // of the samples
  std::size_t columns_ = 0;
  int faults_ = 0;
};

}  // namespace

std::vector<EgoSample> read_ego_trace(const fs::path& file, std::vector<Problem>& problems) {
  TraceReader reader(file, problems);
  std::error_code error;
  if (!fs::is_regular_file(file, error)) {
    const bool exists = fs::exists(file, error);
    reader.problem(0, "", exists ? "is not a plain file" : "does not exist", "check the path");
    return {};
  }
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    reader.problem(0, "", "cannot be read", "check the permissions");
    return {};
  }
  std::string line;
  int number = 0;
  while (std::getline(stream, line))
    if (!reader.take(line, ++number)) return {};
  if (stream.bad()) {
    reader.problem(number, "", "cannot be read any further", "copy it again");
    return {};
  }
  reader.end();
  return std::move(reader.samples);
}

}  // namespace vildar
