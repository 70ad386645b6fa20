#pragma once

#include <ctime>
#include <map>
#include <string>

namespace vildar {

/// Adds the CPU time of this process since the last call to one stage of the table, in seconds.
class StageTimer {
 public:
  explicit StageTimer(std::map<std::string, double>& table)
      : table_(table), last_s_(process_cpu_s()) {}
  void charge(const char* stage) {
    const double now_s = process_cpu_s();
    table_[stage] += now_s - last_s_;
    last_s_ = now_s;
  }

 private:
  static double process_cpu_s() {
    timespec now{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  }

  std::map<std::string, double>& table_;
  double last_s_;
};

}  // namespace vildar
