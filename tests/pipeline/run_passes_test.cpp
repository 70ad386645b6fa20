#include <gtest/gtest.h>

#include <initializer_list>
#include <vector>

#include "core/random.h"
#include "pipelines/run_passes.h"

namespace vildar {
namespace {

constexpr double kSpeed_mps = 50.0;

Site site_of_one_photodiode() {
  Site site;
  PhotodiodeSite photodiode;
  photodiode.id = "near";
  site.photodiodes.push_back(photodiode);
  return site;
}

// Vehicles that drive by at these times, each 5 m beside the photodiode.
PowerTrace trace_of(std::initializer_list<double> peaks_s) {
  PowerTrace trace;
  trace.photodiode = 0;
  trace.sample_period_s = 1e-3;
  trace.noise_sigma_w = 3e-10;
  Random random(7);
  for (int k = 0; k < 15'000; ++k) {
    const double time_s = trace.sample_period_s * k;
    double power_w = random.normal(0.0, trace.noise_sigma_w);
    for (const double peak_s : peaks_s) {
      const double before_m = kSpeed_mps * (peak_s - time_s);
      if (before_m > 0.0) power_w += 5e-5 / (before_m * before_m + 25.0);
    }
    trace.time_s.push_back(time_s);
    trace.power_w.push_back(static_cast<float>(power_w));
  }
  return trace;
}

// Measured 50 m before the photodiode when the clip ended at 5 s.
VehicleResult seen_last() {
  VehicleResult vehicle;
  vehicle.track_id = 1;
  vehicle.t_first_s = 3.0;
  vehicle.t_last_s = 5.0;
  vehicle.speed.time_s = 5.0;
  vehicle.speed.speed_mps = kSpeed_mps;
  vehicle.range_ref_m = 50.0;
  return vehicle;
}

TEST(UnseenPasses, OneWhoDroveByClaimsNoPassOfLaterOnes) {
  const Site site = site_of_one_photodiode();
  const std::vector<PowerTrace> traces{trace_of({6.0, 8.5})};
  for (const bool withheld : {false, true}) {
    std::vector<VehicleResult> vehicles{seen_last()};
    if (withheld) vehicles[0].withheld = Miss::bad_fit;
    RunSummary summary;
    add_unseen_passes(site, traces, {5.0, false}, vehicles, summary);
    EXPECT_EQ(summary.counts["passes_unseen_by_camera"], 0);
    // Of one without a speed it is not known when it drove by.
    EXPECT_EQ(summary.counts["passes_outside_clip"], withheld ? 0 : 1);
    EXPECT_EQ(vehicles.size(), 1U);
  }
}

}  // namespace
}  // namespace vildar
