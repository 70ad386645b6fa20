#include "pipelines/progress.h"

#include <unistd.h>
#include <algorithm>
#include <cstdio>

namespace vildar {
namespace {
constexpr int kBarColumns = 30;
constexpr std::chrono::milliseconds kRedraw{100};
}  // namespace

Progress::Progress(std::string what, std::optional<std::int64_t> total, std::string units)
    : what_(std::move(what)),
      total_(total),
      units_(std::move(units)),
      terminal_(::isatty(STDERR_FILENO) == 1),
      started_(std::chrono::steady_clock::now()),
      drawn_(started_ - kRedraw) {}

Progress::~Progress() {
  if (terminal_) std::fprintf(stderr, "\r\033[K");
}

void Progress::update(std::int64_t done) {
  if (!terminal_) return;
  const auto now = std::chrono::steady_clock::now();
  if (now - drawn_ < kRedraw) return;
  drawn_ = now;
  const double elapsed_s = std::chrono::duration<double>(now - started_).count();
  const double rate_hz = elapsed_s > 0.0 ? static_cast<double>(done) / elapsed_s : 0.0;
  const int digits = rate_hz < 10.0 ? 1 : 0;
  if (total_ && *total_ > 0) {
    const double share =
        std::clamp(static_cast<double>(done) / static_cast<double>(*total_), 0.0, 1.0);
    const int filled = static_cast<int>(share * kBarColumns);
    std::string bar(static_cast<std::size_t>(filled), '#');
    bar.resize(kBarColumns, '.');
    std::fprintf(stderr, "\r%s [%s] %3.0f %%  %.*f %s/s\033[K", what_.c_str(), bar.c_str(),
                 100.0 * share, digits, rate_hz, units_.c_str());
  } else {
    std::fprintf(stderr, "\r%s %lld %s  %.*f %s/s\033[K", what_.c_str(),
                 static_cast<long long>(done), units_.c_str(), digits, rate_hz, units_.c_str());
  }
  std::fflush(stderr);
}

}  // namespace vildar
