#include "synth/frame_times.h"

#include <algorithm>
#include <cmath>

#include "core/random.h"

namespace vildar {

bool frames_uneven(const Scenario& scenario) {
  const FrameTimesScene& scene = scenario.frame_times;
  return scene.jitter_s > 0.0 || scene.dropped_share > 0.0 || !scene.dropped.empty();
}

std::vector<double> frame_times_s(const Scenario& scenario) {
  const FrameTimesScene& scene = scenario.frame_times;
  constexpr double kSlack = 1e-9;  // a duration of n frame times is n frames
  const auto count = std::max<std::int64_t>(
      1,
      static_cast<std::int64_t>(std::ceil(scenario.duration_s * scenario.frame_rate_hz - kSlack)));
  const bool uneven = frames_uneven(scenario);
  // Pictures keep their order, at least a tenth of the usual time apart.
  const double most_s = 0.45 / scenario.frame_rate_hz;
  Random random(scenario.seed ^ 0x6672616d6573ULL);
  std::vector<double> times_s;
  for (std::int64_t i = 0; i < count; ++i) {
    double time_s = static_cast<double>(i) / scenario.frame_rate_hz;
    if (uneven) {
      const double late_s = std::clamp(random.normal(0.0, scene.jitter_s), -most_s, most_s);
      const bool lost =
          random.uniform() < scene.dropped_share ||
          std::find(scene.dropped.begin(), scene.dropped.end(), i) != scene.dropped.end();
      if (i > 0 && lost) continue;
      if (i > 0) time_s = std::round((time_s + late_s) * kUnevenTicks_hz) / kUnevenTicks_hz;
    }
    times_s.push_back(time_s);
  }
  return times_s;
}

std::int64_t frame_count(const Scenario& scenario) {
  return static_cast<std::int64_t>(frame_times_s(scenario).size());
}

}  // namespace vildar
