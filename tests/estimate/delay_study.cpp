#include <cmath>
#include <cstdio>

#include "delay_bound.h"
#include "delay_pass.h"
#include "estimate/delay_light.h"
#include "study.h"

namespace vildar {
namespace {

constexpr int kTrials = 1000;
// Standard error of a ratio of rms values, and three binomial sigmas of a coverage of 95 %.
constexpr double kRatioError = 0.0224, kCoverageSlack = 0.0207;

struct Case {
  double baseline_m = 2.0, baseline_std_m = 0.0;
  double snr_db = 40.0, ripple = 0.1;
  double gain_std = 0.002;  // what the site file says of gain and angular response
  double gain_error = 0.0, angular_error = 0.0;  // of the far one, beyond what is drawn from that
  bool angles_drawn = true;
  bool wanders = false;  // the acceleration, as the estimator takes it to do
  // Where given, vehicles that brake (or speed up) by this much and do not stop before the masts.
  double acceleration_mps2 = NAN;
  bool in_view = false;  // and begin to do so somewhere in view
};

simulated::Vehicle vehicle_of(const Case& tried, double& wander_mps2_per_root_s, Random& random) {
  if (tried.wanders) return simulated::wandering_vehicle(random, wander_mps2_per_root_s);
  simulated::Vehicle vehicle = simulated::random_vehicle(1.5, random);
  if (std::isnan(tried.acceleration_mps2)) return vehicle;
  vehicle.speed_mps = random.uniform(26.0, 35.0);
  vehicle.acceleration_mps2 = tried.in_view ? 0.0 : tried.acceleration_mps2;
  const double change_s = random.uniform(0.2, 0.8) * 50.0 / vehicle.speed_mps;
  if (tried.in_view) vehicle.changes = {{change_s, tried.acceleration_mps2}};
  return vehicle;
}

struct Found {
  double error2 = 0.0, sigma2 = 0.0, bound2 = 0.0, bias = 0.0, worst = 0.0;
  int covered = 0, used = 0;

  double rmse() const { return std::sqrt(error2 / used); }
  double sigma() const { return std::sqrt(sigma2 / used); }
  double bound() const { return std::sqrt(bound2 / used); }
  double coverage() const { return static_cast<double>(covered) / used; }
};

Found study(const Case& tried) {
  Random random(20260111);
  Found found;
  for (int i = 0; i < kTrials; ++i) {
    simulated::DelayKnowledge known{.baseline_m = tried.baseline_m,
                                    .baseline_std_m = tried.baseline_std_m,
                                    .gain_std = tried.gain_std,
                                    .angular_std = tried.gain_std};
    const simulated::Vehicle vehicle = vehicle_of(tried, known.wander_mps2_per_root_s, random);
    const simulated::Beam beam = simulated::random_beam(tried.ripple, random);
    const double true_baseline_m = tried.baseline_m + tried.baseline_std_m * random.normal();
    const Site truth = simulated::two_photodiodes(true_baseline_m);
    const Site site =
        simulated::two_photodiodes(tried.baseline_m, tried.gain_std, tried.baseline_std_m);
    simulated::Receiving receiving{.snr_db = tried.snr_db};
    const PowerTrace near = simulated::beam_trace(vehicle, truth, beam, 0, receiving, random);
    receiving.gain = 1.0 + tried.gain_error + tried.gain_std * random.normal();
    receiving.angular_gain = tried.angular_error;
    if (tried.angles_drawn) receiving.angular_gain += tried.gain_std * random.normal();
    const PowerTrace far = simulated::beam_trace(vehicle, truth, beam, 1, receiving, random);
    const std::array<const PowerTrace*, 2> traces{&near, &far};
    const auto outcome = delay_speed(site, traces, 0.0, 8.0);
    const auto* fit = std::get_if<DelayFit>(&outcome);
    if (!fit) continue;
    const double truth_mps = vehicle.speed_at_mps(fit->speed.time_s);
    const double error = fit->speed.speed_mps / truth_mps - 1.0;
    ++found.used;
    found.error2 += error * error;
    found.bias += error / kTrials;
    found.worst = std::max(found.worst, std::abs(error));
    found.sigma2 += std::pow(fit->speed.std_mps / truth_mps, 2);
    found.covered += fit->speed.lo95_mps <= truth_mps && truth_mps <= fit->speed.hi95_mps;
    const simulated::DelayBound bound(vehicle, truth, beam, receiving, known);
    found.bound2 += std::pow(bound.relative_speed(fit->speed.time_s), 2);
  }
  std::printf(
      "B %.0f m +- %.0f mm, %.0f dB, ripple %.1f, alike to %.1f %%, gain %+.1f %% angular %+.1f %% "
      "more, %+.0f m/s^2 %s: n %d rmse %.3f %% sigma %.3f %% bound %.3f %% bias %+.3f %% "
      "coverage %.3f worst %.2f %%\n",
      tried.baseline_m, 1e3 * tried.baseline_std_m, tried.snr_db, tried.ripple,
      100.0 * tried.gain_std, 100.0 * tried.gain_error, 100.0 * tried.angular_error,
      tried.acceleration_mps2,
      tried.wanders   ? "wandering"
      : tried.in_view ? "from somewhere in view"
                      : "throughout",
      found.used, 100.0 * found.rmse(), 100.0 * found.sigma(), 100.0 * found.bound(),
      100.0 * found.bias, found.coverage(), 100.0 * found.worst);
  std::fflush(stdout);
  return found;
}

using DelayStudy = Study;

TEST_F(DelayStudy, MatchedPhotodiodesReachTheirBound) {
  for (const double baseline_m : {2.0, 1.0, 5.0}) {
    const Found found = study({.baseline_m = baseline_m, .gain_std = 0.0});
    EXPECT_GE(found.used, kTrials * 98 / 100);
    EXPECT_LE(found.rmse(), (1.05 + 2.0 * kRatioError) * found.bound());
    EXPECT_GE(found.coverage(), 0.95 - kCoverageSlack);
  }
}

TEST_F(DelayStudy, AMismatchWithinItsSigmaIsCovered) {
  for (const Case& tried : {Case{}, Case{.baseline_m = 1.0}, Case{.baseline_m = 5.0},
                            Case{.snr_db = 30.0}, Case{.ripple = 0.3}, Case{.baseline_std_m = 0.01},
                            Case{.gain_std = 0.01}, Case{.gain_std = 0.02}}) {
    const Found found = study(tried);
    EXPECT_GE(found.used, kTrials * 98 / 100);
    EXPECT_LE(found.rmse(), (1.05 + 2.0 * kRatioError) * found.sigma());
    EXPECT_GE(found.coverage(), 0.95 - kCoverageSlack);
  }
}

TEST_F(DelayStudy, AnAccelerationThatWandersAsTakenBeforehandIsCovered) {
  for (const Case& tried : {Case{.gain_std = 0.0, .wanders = true}, Case{.wanders = true}})
    EXPECT_GE(study(tried).coverage(), 0.93 - kCoverageSlack);
}

TEST_F(DelayStudy, AnAccelerationThatChangesInViewIsCovered) {
  const auto throughout = [](double mps2) {
    return Case{.angles_drawn = false, .acceleration_mps2 = mps2};
  };
  const auto from_in_view = [](double mps2) {
    return Case{.angles_drawn = false, .acceleration_mps2 = mps2, .in_view = true};
  };
  for (const Case& tried :
       {throughout(0.0), throughout(-1.0), throughout(1.0), throughout(-3.0), from_in_view(-1.0),
        from_in_view(1.0), from_in_view(-3.0), from_in_view(-6.0)}) {
    const Found found = study(tried);
    EXPECT_GE(found.used, kTrials * 98 / 100);
    EXPECT_GE(found.coverage(), 0.95 - kCoverageSlack);
  }
}

TEST_F(DelayStudy, AGainThatTheSiteDeniesIsSeen) {
  for (const double gain_error : {0.01, -0.01}) {
    const Found found = study({.gain_error = gain_error, .angles_drawn = false});
    EXPECT_GE(found.used, kTrials * 98 / 100);
    EXPECT_GE(found.coverage(), 0.95 - kCoverageSlack);
  }
}

// Reported: what one vehicle's light tells too little of.
TEST_F(DelayStudy, AnAngularMismatchThatTheSiteDenies) {
  study({.angular_error = 0.01, .angles_drawn = false});
  study({.angular_error = -0.01, .angles_drawn = false});
}

}  // namespace
}  // namespace vildar
