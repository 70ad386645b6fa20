#include "synth/renderer.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "core/quantity.h"
#include "scenes.h"

namespace vildar {
namespace {

// A scene without noise, glare or background, in linear light.
Scenario clean_scene() {
  Scenario scene = small_scene();
  scene.site.camera->response = ResponseKind::linear;
  scene.image.shot_noise = false;
  scene.image.read_noise_e = 0.0;
  scene.image.black_level_e = 0.0;
  scene.image.sky_cd_per_m2 = 0.0;
  scene.image.road_cd_per_m2 = 0.0;
  scene.image.wing_share = 0.0;
  scene.image.road_light = false;
  return scene;
}

double flux_e(const Frame& frame, double full_well_e) {
  double sum = 0.0;
  for (int v = 0; v < frame.luma.height_px; ++v)
    for (int u = 0; u < frame.luma.width_px; ++u)
      sum += (frame.luma.code(u, v) - 16) / 219.0 * full_well_e;
  return sum;
}

TEST(Renderer, TwiceTheDistanceAQuarterOfTheFlux) {
  Scenario scene = clean_scene();
  scene.site.camera->position_m[2].mean = 0.65;
  scene.site.camera->pitch_rad.mean = 0.0;
  scene.site.camera->yaw_rad.mean = 0.0;
  scene.site.road.lanes[0].lateral_m.mean = 0.0;
  scene.image.full_well_e = 2e5;
  scene.vehicles = {car_at(20.0, 0.0)};
  scene.vehicles[0].lamp_separation_m = 0.0;
  scene.vehicles[0].lamp_radius_m = 0.3;  // spread over enough pixels to stay below the full well
  scene.vehicles[0].intensity_cd = 50.0;
  const double near_e = flux_e(Renderer(scene).image(0.0), scene.image.full_well_e);
  // I / D^2, times electrons per lux second, times exposure; codes round to 1/219 of the full well
  // on about 100 pixels.
  EXPECT_NEAR(near_e / (50.0 / 400.0 * 6.3e10 * 0.001), 1.0, 2e-3);
  scene.vehicles[0].along_at_zero_m = 40.0;
  const double far_e = flux_e(Renderer(scene).image(0.0), scene.image.full_well_e);
  EXPECT_NEAR(far_e / near_e, 0.25, 1e-3);
}

TEST(Renderer, LampsFallWhereThePinholeSays) {
  Scenario scene = small_scene();
  scene.vehicles = {car_at(40.0, 0.0)};
  CameraSite& camera = *scene.site.camera;
  camera.yaw_rad.mean = 0.0;
  camera.pitch_rad.mean = 0.0;
  std::vector<LampImage> lamps = Renderer(scene).lamps(0.0);
  ASSERT_EQ(lamps.size(), 2u);
  if (lamps[0].centre_px.x() > lamps[1].centre_px.x()) std::swap(lamps[0], lamps[1]);
  // u = cu - f y / x, v = cv + f (5 - h) / x.
  EXPECT_NEAR(lamps[0].centre_px.x(), 159.5 + 300.0 * (3.0 - 0.625) / 40.0, 1e-9);
  EXPECT_NEAR(lamps[1].centre_px.x(), 159.5 + 300.0 * (3.0 + 0.625) / 40.0, 1e-9);
  EXPECT_NEAR(lamps[0].centre_px.y(), 89.5 + 300.0 * 4.35 / 40.0, 1e-9);
  const double distance_m = std::sqrt(40.0 * 40.0 + 2.375 * 2.375 + 4.35 * 4.35);
  EXPECT_NEAR(lamps[0].disc_radius_px, 300.0 * 0.06 / distance_m, 1e-9);
}

TEST(Renderer, CentroidOfThePictureIsTheProjection) {
  constexpr double kTolerance_px = 0.01;  // 8-bit codes
  Scenario scene = clean_scene();
  scene.image.full_well_e = 5e4;
  scene.vehicles = {car_at(30.0, 0.0)};
  scene.vehicles[0].lamp_separation_m = 0.0;
  scene.vehicles[0].intensity_cd = 1.5;
  Renderer renderer(scene);
  const Frame frame = renderer.image(0.0);
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  double light = 0.0;
  for (int v = 0; v < 180; ++v)
    for (int u = 0; u < 320; ++u) {
      const double code = frame.luma.code(u, v) - 16;
      ASSERT_LT(code, 219) << "clipped";
      light += code;
      moment += code * Eigen::Vector2d(u, v);
    }
  EXPECT_LT((moment / light - renderer.lamps(0.0).at(0).centre_px).norm(), kTolerance_px);
}

TEST(Renderer, NoiseIsShotAndReadNoise) {
  Scenario scene = clean_scene();
  scene.image.full_well_e = 1000.0;
  scene.image.black_level_e = 400.0;
  scene.image.shot_noise = true;
  scene.image.read_noise_e = 10.0;
  const Frame frame = Renderer(scene).image(0.0);
  double sum = 0.0, sum2 = 0.0, neighbours = 0.0;
  const double count = 320.0 * 180.0;
  for (int v = 0; v < 180; ++v)
    for (int u = 0; u < 320; ++u) {
      const double e = (frame.luma.code(u, v) - 16) / 219.0 * 1000.0 - 400.0;
      sum += e;
      sum2 += e * e;
      if (u > 0) neighbours += e * ((frame.luma.code(u - 1, v) - 16) / 219.0 * 1000.0 - 400.0);
    }
  const double step_e = 1000.0 / 219.0;
  const double variance_e2 = 400.0 + 100.0 + step_e * step_e / 12.0;
  EXPECT_NEAR(sum / count, 0.0, 4.5 * std::sqrt(variance_e2 / count));
  EXPECT_NEAR(sum2 / count / variance_e2, 1.0, 4.5 * std::sqrt(2.0 / count));
  EXPECT_NEAR(neighbours / count / variance_e2, 0.0, 4.5 / std::sqrt(count)) << "correlated";
}

TEST(Renderer, SameSeedSamePictureOtherSeedOther) {
  Scenario scene = small_scene();
  scene.vehicles = {car_at(40.0, 20.0)};
  Renderer first(scene), second(scene);
  first.image(0.0);  // the order of pictures does not matter
  const Frame a = first.image(0.2), b = second.image(0.2);
  const std::size_t size = 320 * 180;
  EXPECT_EQ(std::memcmp(a.luma.data, b.luma.data, size), 0);
  EXPECT_EQ(std::memcmp(a.chroma.cr, b.chroma.cr, size / 4), 0);
  scene.seed = 8;
  EXPECT_NE(std::memcmp(a.luma.data, Renderer(scene).image(0.2).luma.data, size), 0);
  EXPECT_EQ(a.index, 5);
  EXPECT_EQ(a.luma.black_code, 16);
  EXPECT_EQ(a.luma.white_code, 235);
}

TEST(Renderer, HeadlampsSaturateAndTailLampsAreRed) {
  Scenario scene = small_scene();
  scene.vehicles = {car_at(40.0, 0.0)};
  Renderer head(scene);
  const Frame oncoming = head.image(0.0);
  const Eigen::Vector2d lamp_px = head.lamps(0.0).at(0).centre_px;
  const int u = static_cast<int>(std::lround(lamp_px.x()));
  const int v = static_cast<int>(std::lround(lamp_px.y()));
  EXPECT_EQ(oncoming.luma.code(u, v), 235);
  EXPECT_NEAR(oncoming.chroma.cr_fraction(u, v), 0.0, 0.05);
  scene.vehicles[0].lane = 1;
  scene.vehicles[0].lamps = VehicleLamps::tail;
  scene.vehicles[0].intensity_cd = 8.0;
  Renderer tail(scene);
  const Frame receding = tail.image(0.0);
  double reddest = 0.0;
  const Eigen::Vector2d tail_px = tail.lamps(0.0).at(0).centre_px;
  for (int row = -6; row <= 6; ++row)
    for (int column = -6; column <= 6; ++column)
      reddest =
          std::max(reddest, receding.chroma.cr_fraction(static_cast<int>(tail_px.x()) + column,
                                                        static_cast<int>(tail_px.y()) + row));
  EXPECT_GT(reddest, 0.15);
}

TEST(Renderer, AWetRoadMirrorsTheLampsBelowTheRoad) {
  Scenario scene = small_scene();
  scene.vehicles = {car_at(40.0, 0.0)};
  const std::vector<LampImage> dry = Renderer(scene).lamps(0.0);
  scene.wet_road = true;
  const std::vector<LampImage> wet = Renderer(scene).lamps(0.0);
  ASSERT_GT(wet.size(), dry.size());
  const Camera camera(*scene.site.camera);
  const auto mirror_px = camera.project({40.0, -3.0, -0.65});
  const auto ground_px = camera.project({40.0, -3.0, 0.0});
  ASSERT_TRUE(mirror_px && ground_px);
  double direct = 0.0, mirrored = 0.0, row_px = 0.0, square_px2 = 0.0;
  for (std::size_t i = 0; i < wet.size(); ++i) {
    (i < dry.size() ? direct : mirrored) += wet[i].flux;
    if (i < dry.size()) continue;
    const double below_px = wet[i].centre_px.y() - mirror_px->y();
    row_px += wet[i].flux * below_px;
    square_px2 += wet[i].flux * (below_px * below_px + std::pow(wet[i].streak_px, 2));
    // Behind its lamps a vehicle sends no light onto the road.
    EXPECT_GT(wet[i].centre_px.y(), ground_px->y());
  }
  EXPECT_LT(mirrored, 0.3 * direct);
  EXPECT_GT(mirrored, 0.01 * direct);
  // The mirror image of height -h, in the middle of its streak.
  row_px /= mirrored;
  EXPECT_NEAR(row_px, 0.0, 1.5);
  // Road at x sends on what falls on it, by the slopes that turn it to the sensor: the light of
  // each metre of road, summed.
  const double height_m = camera.position_m().z(), away_m = std::hypot(40.0, 3.0);
  double light = 0.0, down = 0.0, down2 = 0.0;
  for (double x_m = 0.005; x_m < away_m; x_m += 0.01) {
    const double up = height_m / x_m, in = 0.65 / (away_m - x_m);
    const double here =
        std::exp(-0.5 * std::pow(0.5 * (up - in) / 0.015, 2)) * in / (away_m - x_m) / x_m;
    light += here;
    down += here * up;
    down2 += here * up * up;
  }
  const double spread_px = camera.focal_px() * std::sqrt(down2 / light - std::pow(down / light, 2));
  EXPECT_NEAR(std::sqrt(square_px2 / mirrored - row_px * row_px), spread_px, 0.08 * spread_px);
}

TEST(Renderer, PulsesShorterThanTheExposureComeAndGo) {
  Scenario scene = clean_scene();
  scene.vehicles = {car_at(40.0, 0.0)};
  const double steady = Renderer(scene).lamps(0.0).at(0).flux;
  scene.vehicles[0].waveform = Waveform::pulses(90.0, 0.4, 0.0);
  Renderer renderer(scene);
  for (const double time_s : {0.04, 0.12, 0.2})
    EXPECT_NEAR(renderer.lamps(time_s).at(0).flux / steady,
                scene.vehicles[0].waveform.mean(time_s - 0.0005, time_s + 0.0005), 1e-9);
}

TEST(Renderer, ABeamAndTheAirDecideWhatReachesTheLens) {
  Scenario scene = clean_scene();
  scene.vehicles = {car_at(40.0, 0.0)};
  scene.vehicles[0].beam = LampBeam(LambertianBeam{600.0, 2.6});
  scene.extinction_per_m = 0.02;
  for (const LampImage& lamp : Renderer(scene).lamps(0.0)) {
    const double y_m =
        lamp.disc_radius_px > 0.0 &&
                lamp.centre_px.x() < Camera(*scene.site.camera).project({40.0, -3.0, 0.65})->x()
            ? -2.375
            : -3.625;
    const double distance_m = std::sqrt(1600.0 + y_m * y_m + 4.35 * 4.35);
    const double lux = 600.0 * std::pow(40.0 / distance_m, 2.6) / (distance_m * distance_m) *
                       std::exp(-0.02 * distance_m);
    EXPECT_NEAR(lamp.flux / (lux * 6.3e10 * 0.001), 1.0, 1e-9);
  }
}

TEST(Renderer, AMosaicKeepsGreyLightAndTailLampsRed) {
  Scenario scene = clean_scene();
  scene.image.black_level_e = 3000.0;
  scene.image.bayer = true;
  const Frame grey = Renderer(scene).image(0.0);
  EXPECT_EQ(grey.luma.code(100, 90), static_cast<int>(std::lround(16 + 219 * 0.3)));
  EXPECT_EQ(grey.chroma.cr_fraction(100, 90), 0.0);
  scene.vehicles = {car_at(30.0, 0.0)};
  scene.vehicles[0].lane = 1;
  scene.vehicles[0].lamps = VehicleLamps::tail;
  scene.vehicles[0].intensity_cd = 1.0;
  scene.vehicles[0].lamp_radius_m = 0.3;
  Renderer renderer(scene);
  const Frame red = renderer.image(0.0);
  const Eigen::Vector2d lamp_px = renderer.lamps(0.0).at(0).centre_px;
  EXPECT_GT(red.chroma.cr_fraction(static_cast<int>(lamp_px.x()), static_cast<int>(lamp_px.y())),
            0.05);
}

TEST(RoadLight, IsTheCosineLawOfEachLamp) {
  const LampBeam beam(LambertianBeam{1000.0, 1.0});
  // Twenty metres ahead of a lamp 0.65 m high: I cos(phi) sin(grazing) / D^2.
  const double distance_m = std::hypot(20.0, 0.65);
  EXPECT_NEAR(ground_illuminance_lx(beam, 2, {50.0, -3.0, 0.65}, kPi, 0.0, {30.0, -3.0}),
              2.0 * 1000.0 * (20.0 / distance_m) * (0.65 / distance_m) / (distance_m * distance_m),
              1e-9);
}

TEST(Renderer, HeadlampsLightTheRoadBeforeThem) {
  Scenario scene = clean_scene();
  scene.vehicles = {car_at(45.0, 0.0)};
  scene.vehicles[0].intensity_cd = 1e-9;
  scene.image.road_light = true;
  scene.image.full_well_e = 500.0;
  const auto brightness = [&](double x_m) {
    const auto pixel_px = Camera(*scene.site.camera).project({x_m, -3.0, 0.0});
    const Frame frame = Renderer(scene).image(0.0);
    return frame.luma.code(static_cast<int>(pixel_px->x()), static_cast<int>(pixel_px->y()));
  };
  EXPECT_GT(brightness(35.0), 18);
  EXPECT_EQ(brightness(60.0), 16) << "behind it";
}

TEST(RoadLight, OfAStreetLampIsThatOfAPoint) {
  // Eight metres up, six aside: I h / D^3.
  EXPECT_NEAR(street_illuminance_lx(500.0, {40.0, 3.0, 8.0}, {40.0, -3.0}), 500.0 * 8.0 / 1000.0,
              1e-12);
}

TEST(Renderer, StreetLampsLightTheRoadAndFlicker) {
  Scenario scene = clean_scene();
  StreetLampScene lamp;
  lamp.position_m = {30.0, -3.0, 8.0};
  lamp.intensity_cd = 2000.0;
  scene.street_lamps = {lamp};
  scene.image.road_light = true;
  scene.image.full_well_e = 4000.0;
  scene.site.camera->response = ResponseKind::linear;
  const Camera camera(*scene.site.camera);
  const auto brightness = [&](double x_m, double time_s) {
    const auto pixel_px = camera.project({x_m, -3.0, 0.0});
    const Frame frame = Renderer(scene).image(time_s);
    return frame.luma.code(static_cast<int>(pixel_px->x()), static_cast<int>(pixel_px->y())) - 16;
  };
  const int pool = brightness(30.0, 0.0);
  EXPECT_GT(pool, 20);
  EXPECT_LT(brightness(70.0, 0.0), pool / 3) << "far from the lamp";
  // Quarter of a period of 100 Hz: the crest of the flicker, to the mean over 1 ms and a code.
  scene.street_lamps[0].waveform = Waveform::sine(100.0, 0.5, 0.0);
  const double crest = 1.0 + 0.5 * std::sin(0.1 * kPi) / (0.1 * kPi);
  EXPECT_NEAR(brightness(30.0, 0.0025), pool * crest, 1.5);
  // With 20 ms from first row to last the rows see one and the other half of the flicker.
  scene.site.camera->rolling_shutter_s = 0.02;
  const auto pixel_px = camera.project({30.0, -3.0, 0.0});
  const double row_s = ((pixel_px->y() + 0.5) / 180.0 - 0.5) * 0.02;
  EXPECT_NEAR(brightness(30.0, 0.0025 - row_s), pool * crest, 2.5);
  EXPECT_NEAR(brightness(30.0, 0.0075 - row_s), pool * (2.0 - crest), 2.5);
}

TEST(Renderer, NeedsACameraWithAnExposure) {
  Scenario scene = small_scene();
  scene.site.camera->exposure_s.reset();
  EXPECT_THROW(Renderer{scene}, std::invalid_argument);
  scene.site.camera.reset();
  EXPECT_THROW(Renderer{scene}, std::invalid_argument);
}

}  // namespace
}  // namespace vildar
