#include <benchmark/benchmark.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "capture/photodiode_csv.h"
#include "core/random.h"

namespace vildar {
namespace {

/// A trace of 2 million rows in the given number format, about 30 to 50 MB; removed at the end.
class TraceFile {
 public:
  explicit TraceFile(const char* row_format) {
    path_ = std::filesystem::temp_directory_path() /
            ("vildar_bench_" + std::to_string(::getpid()) + ".csv");
    std::ofstream file(path_);
    file << "t_s,power_w\n";
    Random random(1);
    char row[80];
    for (int k = 0; k < 2'000'000; ++k) {
      std::snprintf(row, sizeof row, row_format, k * 1e-4, random.uniform(0.0, 3.0));
      file << row;
    }
  }
  ~TraceFile() { std::filesystem::remove(path_); }
  TraceFile(const TraceFile&) = delete;
  TraceFile& operator=(const TraceFile&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

void read_csv(benchmark::State& state, const char* row_format) {
  const TraceFile file(row_format);
  for (auto _ : state) benchmark::DoNotOptimize(read_photodiode_csv(file.path()));
  state.SetBytesProcessed(state.iterations() *
                          static_cast<std::int64_t>(std::filesystem::file_size(file.path())));
}

BENCHMARK_CAPTURE(read_csv, four_decimals, "%.4f,%.4f\n")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_csv, exponents, "%.6f,%.6e\n")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(read_csv, seventeen_digits, "%.17g,%.17g\n")->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace vildar
