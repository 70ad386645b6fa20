#include <cmath>

#include <gtest/gtest.h>

#include "detect/detector.h"
#include "estimate/power_bound.h"
#include "estimate/power_estimators.h"
#include "synth/renderer.h"

namespace vildar {
namespace {

constexpr double kSpeed_mps = 20.0;
constexpr double kStart_m = 40.0;
constexpr double kLateral_m = -3.0;
constexpr double kHeight_m = 1.0;  // of the camera above the lamp
constexpr double kIntensity_cd = 600.0;
constexpr double kExposure_s = 0.002;
constexpr int kFrames = 36;
constexpr double kFrameRate_hz = 30.0;

// One lamp on a dark road, never clipped: 40 to 16.7 m.
Scenario one_lamp(std::uint64_t seed) {
  Scenario scene;
  scene.duration_s = kFrames / kFrameRate_hz;
  scene.frame_rate_hz = kFrameRate_hz;
  scene.seed = seed;
  CameraSite camera;
  camera.width_px = 480;
  camera.height_px = 160;
  camera.focal_px = {800.0, 800.0};
  camera.principal_px = {120.0, 60.0};
  camera.position_m = {Uncertain{}, Uncertain{}, Uncertain{0.65 + kHeight_m, 0.0}};
  camera.exposure_s = kExposure_s;
  camera.response = ResponseKind::srgb;
  scene.site.camera = camera;
  scene.site.road.lanes = {{"near", {kLateral_m, 0.0}, 3.5, Direction::oncoming}};
  VehicleScene lamp;
  lamp.id = "one";
  lamp.kind = VehicleKind::motorcycle;
  lamp.speed_mps = kSpeed_mps;
  lamp.along_at_zero_m = kStart_m;
  lamp.lamp_height_m = 0.65;
  lamp.lamp_separation_m = 0.0;
  lamp.lamp_radius_m = 0.08;
  lamp.intensity_cd = kIntensity_cd;
  scene.vehicles = {lamp};
  scene.image.electrons_per_lux_s = 1.2e7;
  scene.image.wing_share = 0.0;
  scene.image.road_light = false;
  return scene;
}

struct Pass {
  std::vector<double> time_s, flux, sigma;
};

// What the detector reports of the lamp in each frame.
Pass seen(const Scenario& scene) {
  Renderer renderer(scene);
  Detector detector(DetectOptions{}, Response(*scene.site.camera), kExposure_s);
  Pass pass;
  for (int i = 0; i < kFrames; ++i) {
    const double t_s = i / kFrameRate_hz;
    const BlobFrame blobs = detector.detect(renderer.image(t_s));
    const Blob* brightest = nullptr;
    for (const Blob& blob : blobs.blobs)
      if (brightest == nullptr || blob.flux > brightest->flux) brightest = &blob;
    if (brightest == nullptr || has(brightest->defects, Defect::saturated)) continue;
    pass.time_s.push_back(t_s);
    pass.flux.push_back(brightest->flux);
    pass.sigma.push_back(brightest->flux_sigma);
  }
  return pass;
}

// Speed from the camera's intensity alone, K known, against the bound for the scatter that the
// intensities really have.
TEST(CameraPowerStudy, IntensityReachesItsBound) {
  constexpr int kTrials = 200;
  constexpr double kRatioError = 0.05;  // one sigma of an RMSE from 200 trials
  std::vector<Pass> passes;
  for (int trial = 0; trial < kTrials; ++trial)
    passes.push_back(seen(one_lamp(1000 + static_cast<std::uint64_t>(trial))));
  const std::size_t frames = passes[0].flux.size();
  ASSERT_EQ(frames, static_cast<std::size_t>(kFrames));

  const Scenario scene = one_lamp(1);
  const double gain = kIntensity_cd * scene.image.electrons_per_lux_s / scene.image.full_well_e;
  std::vector<double> scatter(frames), bias(frames);
  for (std::size_t i = 0; i < frames; ++i) {
    double sum = 0.0, sum2 = 0.0, reported = 0.0;
    for (const Pass& pass : passes) {
      ASSERT_EQ(pass.flux.size(), frames);
      sum += pass.flux[i];
      sum2 += pass.flux[i] * pass.flux[i];
      reported += pass.sigma[i] / kTrials;
    }
    const double mean = sum / kTrials, range_m = kStart_m - kSpeed_mps * passes[0].time_s[i];
    const double distance2 = range_m * range_m + kLateral_m * kLateral_m + kHeight_m * kHeight_m;
    scatter[i] = std::sqrt((sum2 / kTrials - mean * mean) * kTrials / (kTrials - 1.0));
    bias[i] = mean * distance2 / gain - 1.0;
    if (i % 5 == 0)
      std::printf("R %.1f m: intensity %+.2f %%, scatter %.2f %%, reported %.2f %%\n", range_m,
                  100.0 * bias[i], 100.0 * scatter[i] / mean, 100.0 * reported / mean);
  }

  PowerProblem problem;
  problem.setting.height_m = kHeight_m;
  problem.known[kPowerLogGain] = Uncertain{std::log(gain), 0.0};
  problem.known[kPowerPerpendicular] = Uncertain{kLateral_m, 0.0};
  problem.known[kPowerExponent] = Uncertain{2.0, 0.0};
  PowerVector truth = PowerVector::Zero();
  truth[kPowerSpeed] = kSpeed_mps;
  truth[kPowerRange] = kStart_m;
  truth[kPowerLogGain] = std::log(gain);
  truth[kPowerPerpendicular] = kLateral_m;
  truth[kPowerExponent] = 2.0;
  const auto bound = std::get<PowerMatrix>(power_bound(
      passes[0].time_s, std::span<const double>(scatter), truth, problem.known, problem.setting));
  double sum = 0.0, sum2 = 0.0;
  int covered = 0;
  for (const Pass& pass : passes) {
    problem.time_s = pass.time_s;
    problem.power_w = pass.flux;
    problem.sigma_w = pass.sigma;
    const PowerOutcome outcome = estimate_power(problem, PowerMethod::max_likelihood);
    ASSERT_TRUE(std::holds_alternative<PowerEstimate>(outcome));
    const auto& estimate = std::get<PowerEstimate>(outcome);
    const double error = estimate.speed_mps() - kSpeed_mps;
    sum += error;
    sum2 += error * error;
    const auto interval = estimate.speed_95_mps();
    covered += interval[0] < kSpeed_mps && kSpeed_mps < interval[1];
  }
  const double sigma_mps = std::sqrt(bound(kPowerSpeed, kPowerSpeed));
  std::printf("camera intensity: RMSE / bound %.3f, bias %.3f sigma, coverage %.3f\n",
              std::sqrt(sum2 / kTrials) / sigma_mps, sum / kTrials / sigma_mps,
              covered / static_cast<double>(kTrials));
  EXPECT_LT(std::sqrt(sum2 / kTrials) / sigma_mps, 1.1 + 2.0 * kRatioError);
}

}  // namespace
}  // namespace vildar
