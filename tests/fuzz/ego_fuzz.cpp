#include <cmath>

#include "config/ego_trace.h"
#include "fuzz/fuzz_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::vector<vildar::Problem> problems;
  const auto samples = vildar::read_ego_trace(vildar::fuzz::file_with(data, size), problems);
  vildar::fuzz::require(!problems.empty() || !samples.empty(), "an empty trace is a problem");
  if (!problems.empty()) return 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const vildar::EgoSample& sample = samples[i];
    vildar::fuzz::require(std::isfinite(sample.time_s) && std::isfinite(sample.yaw_rate_rad_per_s),
                          "numbers are finite");
    vildar::fuzz::require(std::isfinite(sample.speed_mps) && sample.speed_mps >= 0.0,
                          "speeds are finite and not negative");
    vildar::fuzz::require(i == 0 || sample.time_s > samples[i - 1].time_s, "times increase");
  }
  return 0;
}
