#include <cmath>
#include <cstdio>

#include <gtest/gtest.h>

#include "calib/site/learn.h"
#include "estimate/study.h"
#include "estimate/vehicle.h"
#include "simulated_site.h"

namespace vildar {
namespace {

constexpr int kSites = 50;

// Errors over their sigmas, and what they sum up to.
struct Errors {
  double squares = 0.0, whitened = 0.0;
  int count = 0, inside = 0, withheld = 0;

  void add(double error, double std, bool covered) {
    squares += error * error;
    whitened += error * error / (std * std);
    ++count;
    inside += covered;
  }
  double rms() const { return std::sqrt(squares / count); }
  double coverage() const { return static_cast<double>(inside) / count; }
};

void add_speeds(const std::vector<simulated::TrueVehicle>& passes, const Site& site,
                Errors& errors) {
  for (const simulated::TrueVehicle& pass : passes) {
    const VehicleResult result = estimate_vehicle(pass.track, site, {}).result;
    if (result.withheld) {
      ++errors.withheld;
      continue;
    }
    const SpeedEstimate& speed = result.speed;
    const double truth_mps = pass.vehicle.speed_at_mps(speed.time_s);
    errors.add(speed.speed_mps / truth_mps - 1.0, speed.std_mps / speed.speed_mps,
               speed.lo95_mps <= truth_mps && truth_mps <= speed.hi95_mps);
  }
}

struct Found {
  Errors turns, before, after;
  double stated_before = 0.0, stated_after = 0.0;
};

Found study(double camera_height_m, double turn_std_rad, int passes, double to_m,
            std::uint64_t seed, double focal_relative_std = 0.0) {
  Random random(seed);
  Site stated = simulated::roughly_known_site(camera_height_m, turn_std_rad);
  stated.camera->focal_std_px = focal_relative_std * stated.camera->focal_px[0];
  Found found;
  for (int i = 0; i < kSites; ++i) {
    const auto truth = simulated::true_site(stated, random);
    const auto seen = simulated::passes_of(truth, passes, to_m, random);
    const auto outcome = learn_site(simulated::tracks_of(seen), stated);
    const auto* learning = std::get_if<SiteLearning>(&outcome);
    if (learning == nullptr) {
      ADD_FAILURE() << name_of(std::get<Miss>(outcome));
      continue;
    }
    const CameraSite &learned = *learning->site.camera, &is = *truth.site.camera;
    for (const LearnedQuantity& one : learning->quantities) {
      if (!one.angle || one.key == "camera.roll_deg") continue;
      const bool yaw = one.key == "camera.yaw_deg";
      const double error_rad =
          yaw ? learned.yaw_rad.mean - is.yaw_rad.mean : learned.pitch_rad.mean - is.pitch_rad.mean;
      found.turns.add(error_rad, one.mean_std, std::abs(error_rad) < 1.96 * one.mean_std);
    }
    // Vehicles that took no part in the learning.
    const auto later = simulated::passes_of(truth, 20, to_m, random);
    add_speeds(later, stated, found.before);
    add_speeds(later, learning->site, found.after);
    found.stated_before += learning->speed_std_before / kSites;
    found.stated_after += learning->speed_std_after / kSites;
  }
  std::printf(
      "turns: rms %.3f mrad, coverage %.3f, z rms %.2f\n"
      "speed before: rmse %.2f %% (stated %.2f), coverage %.3f, withheld %d\n"
      "speed after:  rmse %.2f %% (stated %.2f), coverage %.3f, withheld %d\n",
      1e3 * found.turns.rms(), found.turns.coverage(),
      std::sqrt(found.turns.whitened / found.turns.count), 100.0 * found.before.rms(),
      100.0 * found.stated_before, found.before.coverage(), found.before.withheld,
      100.0 * found.after.rms(), 100.0 * found.stated_after, found.after.coverage(),
      found.after.withheld);
  return found;
}

// Two turns a site: a coverage of n scatters by sqrt(.95 .05 / n), three of these. Speeds share the
// scale of their site, so that of their coverage counts as of two a site.
constexpr double kCoverageSlack = 0.065;
// An RMSE of n scatters by 1 / sqrt(2 n), n as for the coverage; three of these.
constexpr double kRmseSlack = 0.21;

void expect_true_sigmas(const Found& found) {
  EXPECT_NEAR(found.turns.coverage(), 0.95, kCoverageSlack);
  EXPECT_NEAR(found.after.coverage(), 0.95, kCoverageSlack);
  EXPECT_NEAR(found.after.rms() / found.stated_after, 1.0, kRmseSlack);
  EXPECT_LE(found.after.withheld, found.before.withheld);
}

using LearnStudy = Study;

// Long views of each pass tell the pose by themselves: what is left is the scale, which no pass
// tells.
TEST_F(LearnStudy, HighMast) { expect_true_sigmas(study(4.0, 0.01, 30, 15.0, 20260201)); }
TEST_F(LearnStudy, LowMast) { expect_true_sigmas(study(1.5, 0.01, 30, 15.0, 20260203)); }

// Short views need the pose that all passes together tell.
TEST_F(LearnStudy, HighMastShortViews) {
  const Found found = study(4.0, 0.01, 30, 40.0, 20260202);
  expect_true_sigmas(found);
  EXPECT_LT(found.after.rms(), 0.9 * found.before.rms());
}
TEST_F(LearnStudy, FewPasses) { expect_true_sigmas(study(4.0, 0.01, 12, 30.0, 20260204)); }

// All passes see the road through one lens.
TEST_F(LearnStudy, FocalLengthUnsure) {
  expect_true_sigmas(study(4.0, 0.01, 30, 15.0, 20260205, 0.03));
}
TEST_F(LearnStudy, FocalLengthUnsureShortViews) {
  expect_true_sigmas(study(4.0, 0.01, 12, 30.0, 20260206, 0.03));
}

}  // namespace
}  // namespace vildar
