#include <cmath>
#include <cstdio>

#include "delay_pass.h"
#include "estimate/vehicle.h"
#include "study.h"

namespace vildar {
namespace {

constexpr int kTrials = 1000;
constexpr double kCoverageSlack = 0.0207;  // three binomial sigmas of 95 %

struct Found {
  double camera2 = 0.0, fused2 = 0.0, worst = 0.0;
  int covered = 0, used = 0, withheld = 0, fused = 0;

  double rmse() const { return std::sqrt(fused2 / used); }
};

// A camera on a mast and two photodiodes, one beside it, one up the road; beams unlike any model's.
// `change_mps2`: by how much the acceleration changes, somewhere in view or, where the camera sees
// the vehicle for `seen_m` alone, in the 10 m behind that.
Found study(double camera_height_m, double ripple, double baseline_std_m, double change_mps2,
            double seen_m = 50.0) {
  Random random(20260141);
  Site site = simulated::two_photodiodes(2.0, 0.002, baseline_std_m);
  site.camera = simulated::mast_site(camera_height_m).camera;
  for (PhotodiodeSite& photodiode : site.photodiodes) {
    photodiode.position_m[2] = site.camera->position_m[2];
    photodiode.time_offset_s.std = 0.002;
  }
  Found found;
  for (int i = 0; i < kTrials; ++i) {
    simulated::Vehicle vehicle = simulated::random_vehicle(1.5, random);
    if (change_mps2 != 0.0) {
      vehicle.speed_mps = random.uniform(26.0, 35.0);  // it does not stop before the masts
      vehicle.acceleration_mps2 = 0.0;
      const double change_s =
          (seen_m < 50.0 ? seen_m + random.uniform(0.0, 10.0) : random.uniform(0.2, 0.8) * seen_m) /
          vehicle.speed_mps;
      vehicle.changes = {{change_s, change_mps2}};
    }
    const simulated::Beam beam = simulated::random_beam(ripple, random);
    Site truth = site;
    truth.photodiodes[1].position_m[0].mean += baseline_std_m * random.normal();
    simulated::Receiving receiving{.time_offset_s = random.normal(0.0, 0.002)};
    const PowerTrace near = simulated::beam_trace(vehicle, truth, beam, 0, receiving, random);
    receiving.gain = 1.0 + 0.002 * random.normal();
    const PowerTrace far = simulated::beam_trace(vehicle, truth, beam, 1, receiving, random);
    const simulated::View view{.to_s = seen_m / vehicle.speed_mps};
    const VehicleTrack track = simulated::track_of(vehicle, site, view, random);
    const std::array<VehiclePower, 2> power{VehiclePower{&near, false}, VehiclePower{&far, false}};
    const VehicleResult camera = estimate_vehicle(track, site, {}).result;
    const VehicleResult both = estimate_vehicle(track, site, power).result;
    if (camera.withheld || both.withheld) {
      ++found.withheld;
      continue;
    }
    ++found.used;
    found.fused += both.method == Method::fused;
    const auto error = [&](const VehicleResult& result) {
      return result.speed.speed_mps / vehicle.speed_at_mps(result.speed.time_s) - 1.0;
    };
    found.camera2 += std::pow(error(camera), 2);
    found.fused2 += std::pow(error(both), 2);
    found.worst = std::max(found.worst, std::abs(error(both)));
    const double truth_mps = vehicle.speed_at_mps(both.speed.time_s);
    found.covered += both.speed.lo95_mps <= truth_mps && truth_mps <= both.speed.hi95_mps;
  }
  std::printf(
      "camera %.1f m, %.0f m of view, ripple %.1f, B 2 m +- %.0f mm, %+.0f m/s^2: camera %.2f %%, "
      "with two "
      "photodiodes %.3f %%, "
      "coverage %.3f, worst %.2f %%, fused %d of %d, withheld %d\n",
      camera_height_m, seen_m, ripple, 1e3 * baseline_std_m, change_mps2,
      100.0 * std::sqrt(found.camera2 / found.used), 100.0 * found.rmse(),
      static_cast<double>(found.covered) / found.used, 100.0 * found.worst, found.fused, found.used,
      found.withheld);
  std::fflush(stdout);
  return found;
}

using DelayJointStudy = Study;

TEST_F(DelayJointStudy, TwoPhotodiodesBreakTheScaleWhateverTheBeam) {
  struct Case {
    double camera_height_m, ripple, baseline_std_m, most;
  };
  for (const Case& tried : {Case{4.0, 0.1, 0.0, 0.006}, Case{4.0, 0.3, 0.0, 0.006},
                            Case{1.5, 0.3, 0.0, 0.006}, Case{4.0, 0.3, 0.01, 0.008}}) {
    const Found found = study(tried.camera_height_m, tried.ripple, tried.baseline_std_m, 0.0);
    EXPECT_LE(found.rmse(), tried.most);
    EXPECT_GE(found.covered, found.used * (0.93 - kCoverageSlack));
    EXPECT_GE(found.fused, found.used * 95 / 100);
    EXPECT_LE(found.withheld, kTrials / 50);
  }
}

TEST_F(DelayJointStudy, ABrakingThatBeginsInViewIsCovered) {
  for (const double change_mps2 : {-1.0, -3.0, -6.0}) {
    const Found found = study(4.0, 0.1, 0.0, change_mps2);
    EXPECT_GE(found.covered, found.used * (0.95 - kCoverageSlack));
    EXPECT_LE(found.withheld, kTrials / 20);
  }
}

TEST_F(DelayJointStudy, ABrakingThatBeginsBehindTheCamerasViewIsCovered) {
  for (const double change_mps2 : {-1.0, -3.0, -6.0}) {
    const Found found = study(4.0, 0.1, 0.0, change_mps2, 40.0);
    EXPECT_GE(found.covered, found.used * (0.95 - kCoverageSlack));
    EXPECT_LE(found.withheld, kTrials / 20);
  }
}

}  // namespace
}  // namespace vildar
