#include <gtest/gtest.h>

#include <cmath>
#include <initializer_list>
#include <span>
#include <tuple>
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

// Vehicles that drive by at these times, each so far beside the photodiode.
PowerTrace trace_of(std::initializer_list<double> peaks_s, double aside_m = 5.0) {
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
      if (before_m > 0.0) power_w += 5e-5 / (before_m * before_m + aside_m * aside_m);
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

// Left out where it clips, its light falls into two.
TEST(PassesOf, APeakThatClipsIsNoSecondPass) {
  std::vector<PowerTrace> traces{trace_of({6.0}, 20.0), trace_of({6.0}, 20.0)};
  PowerTrace& clipped = traces[0];
  traces[1].photodiode = 1;
  PowerTrace kept = clipped;
  kept.time_s.clear();
  kept.power_w.clear();
  for (std::size_t i = 0; i < clipped.time_s.size(); ++i) {
    const double to_go_s = 6.0 - clipped.time_s[i];
    if (to_go_s > 0.2 && to_go_s < 1.3) continue;
    kept.time_s.push_back(clipped.time_s[i]);
    kept.power_w.push_back(clipped.power_w[i]);
  }
  clipped = kept;
  ASSERT_EQ(passes_of(std::span(traces).first(1)).size(), 2U);
  const auto passes = passes_of(traces);
  ASSERT_EQ(passes.size(), 1U);
  EXPECT_EQ(passes[0].photodiode, 1);
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

// The clip's last picture is older than the trace's last sample, and the vehicle on its way yet.
TEST(UnseenPasses, ATraceThatEndsWithItsClipHasNoPassOutsideIt) {
  const Site site = site_of_one_photodiode();
  std::vector<PowerTrace> traces{trace_of({9.0, 30.0})};
  const auto cut_at = [&](double end_s) {
    PowerTrace cut = traces[0];
    const auto count = static_cast<std::size_t>(std::lround(end_s / cut.sample_period_s));
    cut.time_s.resize(count);
    cut.power_w.resize(count);
    return std::vector{cut};
  };
  for (const auto& [end_s, comes_s, outside] :
       {std::tuple(5.02, 9.0, 0), {6.5, 9.0, 0}, {8.9, 9.0, 0}, {8.9, 6.0, 1}}) {
    std::vector<VehicleResult> vehicles{seen_last()};
    vehicles[0].range_ref_m = kSpeed_mps * (comes_s - 5.0);
    RunSummary summary;
    add_unseen_passes(site, cut_at(end_s), {5.0, false}, vehicles, summary);
    EXPECT_EQ(summary.counts["passes_outside_clip"], outside) << end_s << ", " << comes_s;
  }
}

}  // namespace
}  // namespace vildar
