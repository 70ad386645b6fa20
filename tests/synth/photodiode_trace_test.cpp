#include "synth/photodiode_trace.h"

#include <cmath>
#include <sstream>

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/quantity.h"
#include "scenes.h"

namespace vildar {
namespace {

// The law written out: K Pt D^-gamma, with everything by hand.
double law_w(double x_m, double lateral_m, double down_m) {
  const double distance_m = std::sqrt(x_m * x_m + lateral_m * lateral_m + down_m * down_m);
  return std::pow(10.0, -4.24) * std::pow(distance_m, -1.8);
}

TEST(RenderTrace, IsTheLawWithoutNoise) {
  constexpr double kRelative = 1e-9;
  Scenario scene = small_scene();
  scene.site.photodiodes[0].time_offset_s.mean = 0.013;
  scene.vehicles = {car_at(60.0, 20.0)};
  const RenderedTrace trace = render_trace(scene);
  ASSERT_EQ(trace.time_s.size(), 400u);
  for (std::size_t i = 0; i < trace.time_s.size(); i += 37) {
    EXPECT_DOUBLE_EQ(trace.time_s[i], static_cast<double>(i) / 1000.0);
    const double clip_s = trace.time_s[i] + 0.013;
    EXPECT_NEAR(trace.power_w[0][i] / law_w(60.0 - 20.0 * clip_s, 3.0, 4.35), 1.0, kRelative);
  }
}

TEST(RenderTrace, TheCosineIsRangeOverDistance) {
  Scenario scene = small_scene();
  scene.site.channel->half_power_angle_rad = radians_from_degrees(40.0);
  scene.vehicles = {car_at(10.0, 0.0)};
  const double order = -std::log(2.0) / std::log(std::cos(40.0 * kPi / 180.0));
  const double distance_m = std::sqrt(100.0 + 9.0 + 4.35 * 4.35);
  EXPECT_NEAR(render_trace(scene).power_w[0][0] /
                  (law_w(10.0, 3.0, 4.35) * std::pow(10.0 / distance_m, order + 1.0)),
              1.0, 1e-9);
}

TEST(RenderTrace, VehiclesAndAmbientAddUp) {
  Scenario scene = small_scene();
  scene.photodiode.ambient_w = 3e-7;
  scene.site.photodiodes[0].gain_ratio.mean = 1.1;
  scene.vehicles = {car_at(30.0, 10.0), car_at(50.0, 15.0)};
  scene.vehicles[1].power_ratio = 0.5;
  EXPECT_NEAR(render_trace(scene).power_w[0][0] /
                  (3e-7 + 1.1 * (law_w(30.0, 3.0, 4.35) + 0.5 * law_w(50.0, 3.0, 4.35))),
              1.0, 1e-9);
}

TEST(RenderTrace, OutsideTheFieldOfViewOrFromBehindNothing) {
  Scenario scene = small_scene();
  scene.vehicles = {car_at(5.0, 0.0)};
  const double angle_rad = std::atan2(std::hypot(3.0, 4.35), 5.0);  // off the axis, which is +x
  scene.site.photodiodes[0].half_field_of_view_rad = angle_rad + 1e-6;
  EXPECT_GT(render_trace(scene).power_w[0][0], 0.0);
  scene.site.photodiodes[0].half_field_of_view_rad = angle_rad - 1e-6;
  EXPECT_EQ(render_trace(scene).power_w[0][0], 0.0);
  scene.site.photodiodes[0].half_field_of_view_rad = 1.5;
  scene.vehicles[0].lamps = VehicleLamps::tail;
  EXPECT_EQ(render_trace(scene).power_w[0][0], 0.0);
}

TEST(RenderTrace, NoiseIsThatOfTheRatio) {
  Scenario scene = small_scene();
  scene.duration_s = 20.0;
  scene.photodiode.snr_db = 26.0;
  scene.vehicles = {car_at(40.0, 0.0)};
  const RenderedTrace trace = render_trace(scene);
  const double signal_w = law_w(40.0, 3.0, 4.35);
  const double sigma_w = signal_w / std::pow(10.0, 26.0 / 20.0);
  double sum = 0.0, sum2 = 0.0;
  for (const double power_w : trace.power_w[0]) {
    sum += power_w - signal_w;
    sum2 += (power_w - signal_w) * (power_w - signal_w);
  }
  const auto samples = static_cast<double>(trace.time_s.size());
  EXPECT_NEAR(sum / samples / sigma_w, 0.0, 4.5 / std::sqrt(samples));
  EXPECT_NEAR(std::sqrt(sum2 / samples) / sigma_w, 1.0, 4.5 / std::sqrt(2.0 * samples));
}

TEST(RenderTrace, ARatioToNothingIsAnError) {
  Scenario scene = small_scene();
  scene.photodiode.snr_db = 30.0;
  EXPECT_THROW(render_trace(scene), ConfigError);
}

TEST(TraceCsv, NamesItsColumns) {
  Scenario scene = small_scene();
  scene.duration_s = 0.003;
  scene.photodiode.digits = 17;
  scene.vehicles = {car_at(40.0, 0.0)};
  RenderedTrace trace = render_trace(scene);
  std::istringstream one(trace_text(scene));
  std::string line;
  std::getline(one, line);
  EXPECT_EQ(line, "t_s,power_w");
  std::getline(one, line);
  EXPECT_EQ(std::stod(line.substr(line.find(',') + 1)), trace.power_w[0][0]);

  scene.site.photodiodes.push_back(scene.site.photodiodes[0]);
  scene.site.photodiodes[1].id = "pd1";
  scene.site.photodiodes[1].position_m[0].mean = 2.0;
  trace = render_trace(scene);
  EXPECT_GT(trace.power_w[1][0], trace.power_w[0][0]) << "two metres nearer";
  const std::string two = trace_text(scene);
  EXPECT_EQ(two.substr(0, two.find('\n')), "t_s,pd0_power_w,pd1_power_w");
}

}  // namespace
}  // namespace vildar
