#include <gtest/gtest.h>

#include "drive_past_lamps.h"
#include "made_scenes.h"

namespace vildar {
namespace {

using scene::car;
using scene::Car;
using scene::dashcam;
using scene::expect_each_car_once;
using scene::Scene;

TEST(DashcamScene, DashcamSeparatesTrafficFromWhatStands) {
  Scene made = dashcam(14.0);
  made.cars = {car(150, 3.6, -13), car(190, 3.6, -12), car(25, 0, 15, LampKind::taillamp),
               car(90, 3.6, 0)};  // the last one waits with its lamps on
  for (int i = 0; i < 6; ++i) made.street_lamps.push_back({30.0 + 25.0 * i, -6.0, 8.0});
  made.duration_s = 6.0;
  const auto outcome = scene::run(made);
  expect_each_car_once(outcome, 4, 0.8);
  for (const VehicleTrack& track : outcome.tracks) EXPECT_FALSE(track.direction_contradicts);
  EXPECT_GE(outcome.counts.static_lights, 4);
}

TEST(DashcamScene, TailLampsThatADashcamOvertakesDoNotContradict) {
  Scene made = dashcam(30.0);
  made.cars = {car(80, -3.5, 20, LampKind::taillamp)};
  const auto outcome = scene::run(made);
  ASSERT_EQ(outcome.tracks.size(), 1U);
  EXPECT_FALSE(outcome.tracks[0].direction_contradicts);
}

TEST(DashcamScene, WhitenedTailLampsAheadOfADashcamRecede) {
  Scene made = dashcam(12.0);
  made.cars = {car(22, 0, 12.5)};
  made.cars[0].cr = 0.045;
  made.duration_s = 6.0;
  const auto outcome = scene::run(made);
  ASSERT_EQ(outcome.tracks.size(), 1U);
  EXPECT_EQ(outcome.tracks[0].kind, LampKind::taillamp);
  EXPECT_EQ(outcome.tracks[0].direction, Direction::receding);
  EXPECT_FALSE(outcome.tracks[0].direction_contradicts);
}

// From low down a body hides what shines between its lamps; the light of its plate it does not.
TEST(DashcamScene, TailLampsAboutALitPlateAreOneVehicle) {
  Scene made = dashcam(12.0);
  Car plate = car(18, 0, 12.5);
  plate.single = true;
  plate.height_m = 0.62;
  made.cars = {car(18, 0, 12.5, LampKind::taillamp), plate};
  made.duration_s = 6.0;
  const auto outcome = scene::run(made);
  ASSERT_EQ(outcome.tracks.size(), 1U);
  EXPECT_EQ(outcome.tracks[0].kind, LampKind::taillamp);
  EXPECT_FALSE(outcome.tracks[0].single_lamp);
}

TEST(DashcamScene, WhiteLightsThatKeepAheadOfADashcamAreNoOncomingVehicle) {
  Scene made = dashcam(12.0);
  made.cars = {car(22, 0, 12.5)};
  made.duration_s = 6.0;
  EXPECT_TRUE(scene::run(made).tracks.empty());
}

// A light that stands moves through a dashcam's picture as its way dictates: what is left is the
// shake.
TEST(DashcamScene, StreetLampsTellADashcamsShake) {
  Scene made;
  made.site = scene::site_of(1.3, -2.0, 800.0, 960, 540);
  made.site.camera->pitch_rad.std = 0.002;
  made.site.ego = EgoSite{{12.0, 0.1}, {}, {}};
  Car car;
  car.x_m = 150.0;
  car.y_m = 3.5;
  car.speed_mps = -8.0;
  made.cars = {car};
  for (int i = 0; i < 10; ++i)
    made.street_lamps.emplace_back(30.0 + 22.0 * i, i % 2 ? 9.0 : -6.0, 8.0);
  made.shake_px = 2.0;
  const scene::Outcome shaken = scene::run(made);
  double square_px2 = 0.0, frames = 0.0;
  for (std::size_t k = 0; k < shaken.turns.size(); ++k) {
    if (!shaken.turns[k]) continue;
    const Eigen::Vector3d& turn_rad = shaken.turns[k]->rotation_rad;
    square_px2 +=
        (800.0 * Eigen::Vector2d(-turn_rad.y(), turn_rad.x()) - shaken.shakes_px[k]).squaredNorm();
    frames += 1.0;
  }
  EXPECT_GT(frames, 100.0);
  EXPECT_LT(std::sqrt(0.5 * square_px2 / frames), 0.25 * made.shake_px);
  made.shake_px = 0.0;
  for (const auto& turn : scene::run(made).turns) EXPECT_FALSE(turn);
}

// What drives through a bend and pitches, 15.9 m/s, and a car that comes the other way at 19 m/s:
// the tracks of its lamps, without noise.
std::vector<VehicleTrack> tracks_in_a_bend(double pitch_rad, double pitches_hz) {
  constexpr double kEgo_mps = 15.9, kCar_mps = 19.0, kRate_hz = 30.0, kCurvature_per_m = -1.0 / 148;
  constexpr double kFrom_m = 110.0, kLane_m = 3.5, kHalfSeparation_m = 0.62, kFocal_px = 1000.0;
  constexpr int kFrames = 70;
  Scene made = dashcam(kEgo_mps);
  made.site.road.kind = RoadKind::curved;
  made.site.road.radius_m = Uncertain{148.0, 7.5};
  made.site.road.turn = Turn::right;
  const Camera camera(*made.site.camera);
  Tracker tracker({}, made.site);
  std::vector<VehicleTrack> tracks;
  const auto keep = [&](std::vector<VehicleTrack> ended) {
    for (VehicleTrack& track : ended) tracks.push_back(std::move(track));
  };
  for (int k = 0; k < kFrames; ++k) {
    const double t_s = k / kRate_hz, ego_m = kEgo_mps * t_s;
    BlobFrame frame;
    frame.frame = k;
    frame.time = time_from_seconds<CameraTime>(t_s);
    for (const double aside_m : {kHalfSeparation_m, -kHalfSeparation_m}) {
      const Eigen::Vector2d off_m =
          drive::on_road_m(kFrom_m - kCar_mps * t_s, kLane_m + aside_m, kCurvature_per_m) -
          drive::on_road_m(ego_m, 0.0, kCurvature_per_m);
      const Eigen::Vector2d ahead_m = Eigen::Rotation2Dd(-kCurvature_per_m * ego_m) * off_m;
      Blob blob;
      blob.id = static_cast<int>(frame.blobs.size());
      blob.centre_px = *camera.project({ahead_m.x(), ahead_m.y(), 0.68});
      blob.centre_px.y() += kFocal_px * pitch_rad * std::sin(2.0 * kPi * pitches_hz * t_s);
      blob.centre_sigma_px.setConstant(0.15);
      blob.flux = 1e6 / ahead_m.squaredNorm();
      blob.flux_sigma = 0.05 * blob.flux;
      blob.area_px = 9;
      blob.spread_px.setConstant(1.0);
      const Eigen::Vector2i at_px = blob.centre_px.cast<int>();
      blob.box = {at_px.x() - 2, at_px.y() - 2, at_px.x() + 2, at_px.y() + 2};
      blob.kind = LampKind::headlamp;
      blob.cb = -0.02;
      frame.blobs.push_back(blob);
    }
    keep(tracker.update(frame));
  }
  keep(tracker.finish());
  return tracks;
}

// There the turning of the own vehicle, and not how lamps near, is the most of how they move in the
// picture.
TEST(DashcamScene, AnOncomingCarInABendStaysOneWhereTheCameraPitches) {
  constexpr std::size_t kFrames = 70;
  for (const double pitch_rad : {0.002, 0.003, 0.004})
    for (const double pitches_hz : {1.0, 1.5, 2.0, 2.5}) {
      const std::vector<VehicleTrack> tracks = tracks_in_a_bend(pitch_rad, pitches_hz);
      ASSERT_EQ(tracks.size(), 1U) << pitch_rad << " rad, " << pitches_hz << " Hz";
      EXPECT_GE(tracks.front().sightings.size(), kFrames) << pitch_rad << ' ' << pitches_hz;
    }
}

}  // namespace
}  // namespace vildar
