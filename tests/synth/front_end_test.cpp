#include <cmath>

#include <gtest/gtest.h>

#include "core/quantity.h"
#include "optics/lamp_beam.h"
#include "scenes.h"
#include "synth/photodiode_trace.h"

namespace vildar {
namespace {

// Nothing but ambient light on one photodiode.
Scenario dark_scene() {
  Scenario scene = small_scene();
  scene.site.photodiodes[0].responsivity_a_per_w = 0.45;
  scene.site.photodiodes[0].transimpedance_v_per_a = 1e6;
  scene.photodiode.ambient_w = 2e-6;
  return scene;
}

TEST(FrontEnd, ShotAndThermalNoiseHaveTheirDensities) {
  Scenario scene = dark_scene();
  scene.duration_s = 40.0;
  scene.photodiode.shot_noise = true;
  scene.photodiode.temperature_k = 300.0;
  const auto variance_w2 = [&] {
    double sum = 0.0;
    const RenderedTrace trace = render_trace(scene);
    for (const double power_w : trace.power_w[0]) sum += (power_w - 2e-6) * (power_w - 2e-6);
    return sum / static_cast<double>(trace.time_s.size());
  };
  // 2 q I + 4 k T / R in A^2/Hz, over half the rate without an amplifier pole.
  const double density = 2.0 * 1.602176634e-19 * 2e-6 * 0.45 + 4.0 * 1.380649e-23 * 300.0 / 1e6;
  const double per_watt2 = density / (0.45 * 0.45);
  EXPECT_NEAR(variance_w2() / (per_watt2 * 500.0), 1.0, 4.5 * std::sqrt(2.0 / 40'000.0));
  // A pole at f_c lets pi / 2 f_c through. Its samples hang together over 1 / (2 pi f_c), here
  // a sixth of a sample: they count as independent. The inner steps shift the band by a percent.
  scene.photodiode.bandwidth_hz = 1000.0;
  scene.duration_s = 8.0;
  EXPECT_NEAR(variance_w2() / (per_watt2 * 0.5 * kPi * 1000.0), 1.0,
              0.01 + 4.5 * std::sqrt(2.0 / 8'000.0));
}

TEST(FrontEnd, ThePoleRemembersFromSampleToSample) {
  Scenario scene = dark_scene();
  scene.duration_s = 20.0;
  scene.photodiode.temperature_k = 300.0;
  scene.photodiode.bandwidth_hz = 100.0;
  const std::vector<double> power_w = render_trace(scene).power_w[0];
  double square = 0.0, product = 0.0;
  for (std::size_t i = 1; i < power_w.size(); ++i) {
    square += (power_w[i] - 2e-6) * (power_w[i] - 2e-6);
    product += (power_w[i] - 2e-6) * (power_w[i - 1] - 2e-6);
  }
  EXPECT_NEAR(product / square, std::exp(-2.0 * kPi * 100.0 / 1000.0), 4.5 / std::sqrt(20'000.0));
}

TEST(FrontEnd, ThePoleDampsTheFlicker) {
  Scenario scene = dark_scene();
  scene.duration_s = 1.0;
  scene.photodiode.ambient_flicker = 0.4;
  scene.photodiode.bandwidth_hz = 100.0;  // the flicker of 50 Hz mains is at its pole
  const std::vector<double> power_w = render_trace(scene).power_w[0];
  double cosine = 0.0, sine = 0.0;
  for (std::size_t i = 500; i < 1000; ++i) {
    const double angle_rad = 2.0 * kPi * 100.0 * static_cast<double>(i) / 1000.0;
    cosine += power_w[i] * std::cos(angle_rad) / 250.0;
    sine += power_w[i] * std::sin(angle_rad) / 250.0;
  }
  EXPECT_NEAR(std::hypot(cosine, sine) / (0.4 * 2e-6), std::sqrt(0.5), 0.01);
  EXPECT_NEAR(std::atan2(cosine, sine), -0.25 * kPi, 0.02);
}

TEST(FrontEnd, PulsesAreIntegratedByThePoleAndHitOrMissedWithoutOne) {
  Scenario scene = small_scene();
  scene.vehicles = {car_at(40.0, 0.0)};
  const double steady_w = render_trace(scene).power_w[0][0];
  scene.vehicles[0].waveform = Waveform::pulses(2000.0, 0.25, 0.1);
  const std::vector<double> sharp_w = render_trace(scene).power_w[0];
  for (const double power_w : sharp_w)
    EXPECT_NEAR(power_w / steady_w, 4.0, 1e-9);  // the rate divides the pulses: always on
  scene.photodiode.bandwidth_hz = 50.0;
  const std::vector<double> smooth_w = render_trace(scene).power_w[0];
  EXPECT_NEAR(smooth_w.back() / steady_w, 1.0, 0.03);
}

TEST(FrontEnd, TheConverterRoundsAndClips) {
  Scenario scene = small_scene();
  scene.vehicles = {car_at(40.0, 60.0)};
  const std::vector<double> exact_w = render_trace(scene).power_w[0];
  scene.photodiode.adc_bits = 8;
  scene.photodiode.full_scale_w = 0.5 * exact_w.back();
  const double step_w = *scene.photodiode.full_scale_w / 255.0;
  const std::vector<double> codes_w = render_trace(scene).power_w[0];
  EXPECT_DOUBLE_EQ(codes_w.back(), *scene.photodiode.full_scale_w);
  for (std::size_t i = 0; i < exact_w.size(); ++i)
    EXPECT_NEAR(codes_w[i], std::min(exact_w[i], *scene.photodiode.full_scale_w),
                0.5 * step_w * (1.0 + 1e-9));
}

TEST(FrontEnd, CountsTurnBackIntoWatts) {
  Scenario scene = dark_scene();
  scene.photodiode.quantity = PowerQuantity::counts;
  scene.photodiode.adc_bits = 16;
  scene.site.photodiodes[0].volts_per_count = 5e-5;
  const std::string text = trace_text(scene);
  EXPECT_EQ(text.substr(0, text.find('\n')), "t_s,counts");
  // 2 uW * 0.45 A/W * 1e6 V/A = 0.9 V.
  EXPECT_NE(text.find("\n0,18000\n"), std::string::npos) << text.substr(0, 60);
}

TEST(FrontEnd, ClockDriftAndGaps) {
  Scenario scene = small_scene();
  scene.duration_s = 2.0;
  scene.vehicles = {car_at(60.0, 20.0)};
  scene.photodiode.clock_drift_ppm = 500.0;
  scene.photodiode.gaps = {{0.5, 0.7}};
  const RenderedTrace trace = render_trace(scene);
  ASSERT_EQ(trace.time_s.size(), 1800u);
  EXPECT_DOUBLE_EQ(trace.time_s[500], 0.7);
  const double x_m = 60.0 - 20.0 * 1.0005 * trace.time_s.back();
  const double distance_m = std::sqrt(x_m * x_m + 9.0 + 4.35 * 4.35);
  EXPECT_NEAR(trace.power_w[0].back() / (std::pow(10.0, -4.24) * std::pow(distance_m, -1.8)), 1.0,
              1e-9);
}

TEST(VehiclePower, FogDimsByTheWayThroughIt) {
  Scenario scene = small_scene();
  scene.vehicles = {car_at(40.0, 0.0)};
  const double clear_w = render_trace(scene).power_w[0][0];
  scene.extinction_per_m = 0.03;
  const double distance_m = std::sqrt(1600.0 + 9.0 + 4.35 * 4.35);
  EXPECT_NEAR(render_trace(scene).power_w[0][0] / clear_w, std::exp(-0.03 * distance_m), 1e-12);
}

TEST(VehiclePower, OfABeamIsTheSumOverTheLamps) {
  Scenario scene = small_scene();
  PhotodiodeSite& diode = scene.site.photodiodes[0];
  diode.area_m2 = 1e-4;
  diode.yaw_rad = -0.1;
  scene.site.channel->beam = "low_beam";
  scene.vehicles = {car_at(40.0, 0.0)};
  scene.vehicles[0].beam = LampBeam(LambertianBeam{500.0, 2.6});
  double sum_w = 0.0;
  for (const double y_m : {-3.0 + 0.625, -3.0 - 0.625}) {
    const Eigen::Vector3d way_m(40.0, y_m, 0.65 - 5.0);
    const double cos_out = way_m.x() / way_m.norm();
    const double cos_in = (way_m.x() * std::cos(-0.1) + way_m.y() * std::sin(-0.1)) / way_m.norm();
    sum_w += 500.0 * std::pow(cos_out, 2.6) * cos_in * 1e-4 / way_m.squaredNorm() / 300.0;
  }
  EXPECT_NEAR(render_trace(scene).power_w[0][0] / sum_w, 1.0, 1e-9);
  // A nose that goes up by 2 degrees turns the beam.
  scene.vehicles[0].pitch = {radians_from_degrees(2.0), 0.5, 0.5 * kPi};
  double up_w = 0.0;
  for (const double y_m : {-3.0 + 0.625, -3.0 - 0.625}) {
    const Eigen::Vector3d way_m(40.0, y_m, 0.65 - 5.0);
    const double up_rad = radians_from_degrees(2.0);
    const double cos_out =
        (way_m.x() * std::cos(up_rad) - way_m.z() * std::sin(up_rad)) / way_m.norm();
    const double cos_in = (way_m.x() * std::cos(-0.1) + way_m.y() * std::sin(-0.1)) / way_m.norm();
    up_w += 500.0 * std::pow(cos_out, 2.6) * cos_in * 1e-4 / way_m.squaredNorm() / 300.0;
  }
  EXPECT_NEAR(render_trace(scene).power_w[0][0] / up_w, 1.0, 1e-9);
}

TEST(FrontEnd, StreetLampsShineOnIt) {
  Scenario scene = small_scene();
  PhotodiodeSite& diode = scene.site.photodiodes[0];
  StreetLampScene lamp;
  lamp.position_m = {30.0, 6.0, 8.0};
  lamp.intensity_cd = 900.0;
  lamp.waveform = Waveform::sine(100.0, 0.3, 0.0);
  scene.street_lamps = {lamp};
  scene.photodiode.ambient_w = 1e-9;
  EXPECT_EQ(render_trace(scene).power_w[0][3], 1e-9) << "without an area nothing can be said";
  diode.area_m2 = 2e-4;
  diode.gain_ratio.mean = 1.1;
  scene.extinction_per_m = 0.01;
  // Mast of 5 m, axis along x: I cos(incidence) area / D^2 / 300 lm/W through the air.
  const double distance_m = std::sqrt(900.0 + 36.0 + 9.0);
  const double mean_w = 1.1 * 900.0 * (30.0 / distance_m) * 2e-4 / (distance_m * distance_m) /
                        300.0 * std::exp(-0.01 * distance_m);
  const std::vector<double> power_w = render_trace(scene).power_w[0];
  for (std::size_t i = 0; i < 40; ++i) {
    const double level = 1.0 + 0.3 * std::sin(2.0 * kPi * 100.0 * 0.001 * static_cast<double>(i));
    EXPECT_NEAR(power_w[i] / (1e-9 + mean_w * level), 1.0, 1e-9) << i;
  }
  diode.half_field_of_view_rad = std::acos(30.0 / distance_m) - 1e-6;
  EXPECT_EQ(render_trace(scene).power_w[0][3], 1e-9) << "outside the field of view";
}

}  // namespace
}  // namespace vildar
