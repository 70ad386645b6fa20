#include <cmath>

#include "capture/photodiode_csv.h"
#include "condition/condition.h"
#include "core/error.h"
#include "fuzz/fuzz_input.h"

namespace {

/// Two photodiodes, with every factor that turns any quantity into watts.
vildar::Site site_of_two() {
  vildar::Site site;
  for (const char* id : {"pd0", "pd1"}) {
    vildar::PhotodiodeSite photodiode;
    photodiode.id = id;
    photodiode.responsivity_a_per_w = 0.45;
    photodiode.transimpedance_v_per_a = 1e6;
    photodiode.volts_per_count = 5e-5;
    site.photodiodes.push_back(photodiode);
  }
  return site;
}

void check(const vildar::PowerTrace& trace) {
  using vildar::fuzz::require;
  require(trace.time_s.size() == trace.power_w.size(), "each sample has a time");
  for (std::size_t i = 0; i < trace.time_s.size(); ++i) {
    require(std::isfinite(trace.time_s[i]) && std::isfinite(trace.power_w[i]),
            "samples in use are finite");
    require(i == 0 || trace.time_s[i] > trace.time_s[i - 1], "times in use increase");
  }
  double end_s = -HUGE_VAL;
  for (const vildar::PowerPass& pass : vildar::find_passes(trace)) {
    require(pass.from_s >= end_s && pass.to_s >= pass.from_s, "passes do not overlap");
    end_s = pass.to_s;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const vildar::Site site = site_of_two();
  try {
    const vildar::PhotodiodeRecording recording =
        vildar::read_photodiode_csv(vildar::fuzz::file_with(data, size));
    for (const auto& channel : recording.values)
      vildar::fuzz::require(channel.size() == recording.time_s.size(), "each row is whole");
    for (const vildar::PowerTrace& trace : vildar::condition(recording, site)) check(trace);
  } catch (const vildar::InputError&) {
  }
  return 0;
}
