#include <benchmark/benchmark.h>

#include <filesystem>
#include <fstream>

#include "core/random.h"
#include "sink/annotator.h"
#include "sink/csv_tables.h"
#include "sink/picture_support.h"
#include "sink/run_summary.h"

namespace vildar {
namespace {

std::filesystem::path scratch(const char* name) {
  return std::filesystem::temp_directory_path() / name;
}

void annotate_1080p(benchmark::State& state) {
  auto made = test::made_frame(1920, 1080, 20);
  Random random(1);
  for (int i = 0; i < 1920 * 1080; ++i)
    (*made.planes)[static_cast<std::size_t>(i)] =
        static_cast<std::uint8_t>(18.0 + 4.0 * random.uniform());
  const auto path = scratch("vildar_bench.mp4");
  {
    Annotator annotator(path, 1920, 1080, 30.0);
    AnnotationBox box;
    box.left = PixelBox{900, 500, 912, 512};
    box.right = PixelBox{980, 500, 992, 512};
    box.label = "#3 52.1 +-0.8 km/h";
    const std::vector<AnnotationBox> boxes{box};
    std::int64_t index = 0;
    for (auto _ : state) {
      made.frame.index = index;
      made.frame.time = time_from_seconds<CameraTime>(static_cast<double>(index++) / 30.0);
      annotator.add(made.frame, boxes);
    }
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(annotate_1080p)->Unit(benchmark::kMillisecond)->UseRealTime();

void write_track_rows(benchmark::State& state) {
  TrackRow row;
  row.sighting.left = LampSighting{};
  row.sighting.right = LampSighting{};
  row.intensity = 1234.5678;
  row.bearing_rad = row.bearing_left_rad = row.bearing_right_rad =
      Eigen::Vector2d(-0.123456, -0.0543);
  row.range_m = row.range_std_m = row.speed_mps = row.speed_std_mps = 12.345678;
  const std::vector<TrackRow> rows(1000, row);
  TracksWriter writer(scratch("vildar_bench.csv"));
  for (auto _ : state) writer.add(rows);
  state.SetItemsProcessed(state.iterations() * 1000);
}
BENCHMARK(write_track_rows)->Unit(benchmark::kMicrosecond);

void hash_input(benchmark::State& state) {
  constexpr std::int64_t kBytes = 64 << 20;
  const auto path = scratch("vildar_bench.bin");
  std::ofstream(path, std::ios::binary) << std::string(kBytes, 'x');
  for (auto _ : state) benchmark::DoNotOptimize(describe_input("clip", path));
  state.SetBytesProcessed(state.iterations() * kBytes);
  std::filesystem::remove(path);
}
BENCHMARK(hash_input)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace vildar
