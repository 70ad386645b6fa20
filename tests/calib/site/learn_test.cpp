#include "calib/site/learn.h"

#include <algorithm>
#include <tuple>

#include <gtest/gtest.h>

#include "simulated_site.h"

namespace vildar {
namespace {

const LearnedQuantity& quantity(const SiteLearning& learning, const std::string& key) {
  const auto found = std::ranges::find(learning.quantities, key, &LearnedQuantity::key);
  if (found == learning.quantities.end()) throw std::runtime_error(key);
  return *found;
}

struct Scene {
  Site stated;
  simulated::TrueSite truth;
  std::vector<VehicleTrack> tracks;
};

Scene scene_of(int passes, std::uint64_t seed) {
  Random random(seed);
  const Site stated = simulated::roughly_known_site(4.0, 0.01);
  const auto truth = simulated::true_site(stated, random);
  return {stated, truth, simulated::tracks_of(simulated::passes_of(truth, passes, 15.0, random))};
}

SiteLearning learning_of(const Scene& scene) {
  const auto outcome = learn_site(scene.tracks, scene.stated);
  if (const Miss* miss = std::get_if<Miss>(&outcome))
    throw std::runtime_error(std::string(name_of(*miss)));
  return std::get<SiteLearning>(outcome);
}

// Five sigmas of a normal error are one in two million.
constexpr double kFar = 5.0;

TEST(LearnSite, FindsThePoseOfTheCamera) {
  const Scene scene = scene_of(12, 1);
  const SiteLearning learning = learning_of(scene);
  const CameraSite &learned = *learning.site.camera, &truth = *scene.truth.site.camera;
  EXPECT_EQ(learning.passes(), 12);
  EXPECT_TRUE(learning.settled());
  const std::vector<std::tuple<std::string, Uncertain, double>> turns{
      {"camera.yaw_deg", learned.yaw_rad, truth.yaw_rad.mean},
      {"camera.pitch_deg", learned.pitch_rad, truth.pitch_rad.mean},
      {"camera.roll_deg", learned.roll_rad, truth.roll_rad.mean}};
  for (const auto& [key, turn_rad, true_rad] : turns) {
    const LearnedQuantity& found = quantity(learning, key);
    EXPECT_LT(std::abs(turn_rad.mean - true_rad), kFar * found.mean_std) << key;
    EXPECT_LT(found.mean_std, 3e-4) << key;  // of 10 or 5 mrad before
    EXPECT_GE(turn_rad.std, found.mean_std) << key;
    EXPECT_EQ(found.after, turn_rad) << key;
  }
}

TEST(LearnSite, ReplacesNothingElse) {
  const Scene scene = scene_of(6, 2);
  SiteLearning learning = learning_of(scene);
  CameraSite& camera = *learning.site.camera;
  camera.yaw_rad = scene.stated.camera->yaw_rad;
  camera.pitch_rad = scene.stated.camera->pitch_rad;
  camera.roll_rad = scene.stated.camera->roll_rad;
  learning.site.lamps = scene.stated.lamps;
  learning.site.road.lanes[0].lateral_m = scene.stated.road.lanes[0].lateral_m;
  EXPECT_EQ(learning.site, scene.stated);
}

TEST(LearnSite, TailLampsThatTheFileLeavesOutStayOut) {
  Scene scene = scene_of(6, 2);
  for (VehicleTrack& track : scene.tracks) track.kind = LampKind::taillamp;
  const SiteLearning learning = learning_of(scene);
  EXPECT_EQ(learning.site.lamps, scene.stated.lamps);
  EXPECT_NE(learning.site.camera->yaw_rad, scene.stated.camera->yaw_rad);
}

TEST(LearnSite, AllLengthsKeepTheScaleOfTheSiteFile) {
  // Bearings are the same in a world twice as large: so is then all that is learned of lengths.
  constexpr double kFactor = 2.0;
  const Scene scene = scene_of(8, 3);
  Scene large = scene;
  const auto stretch = [](Uncertain& value) {
    value = {kFactor * value.mean, kFactor * value.std};
  };
  stretch(large.stated.camera->position_m[2]);
  stretch(*large.stated.lamps.height_m);
  stretch(*large.stated.lamps.separation_m);
  stretch(large.stated.road.lanes[0].lateral_m);
  large.stated.road.lanes[0].width_m *= kFactor;
  const SiteLearning small = learning_of(scene), twice = learning_of(large);
  // Accelerations have a prior in metres, which holds by its share: half a percent of the height.
  const double tolerance_m = 0.005 * large.stated.camera->position_m[2].mean;
  for (const LearnedQuantity& one : small.quantities) {
    const LearnedQuantity& other = quantity(twice, one.key);
    const double factor = one.angle ? 1.0 : kFactor;
    EXPECT_NEAR(other.after.mean, factor * one.after.mean, one.angle ? one.mean_std : tolerance_m)
        << one.key;
    EXPECT_NEAR(other.after.std / one.after.std, factor, 0.05 * factor) << one.key;
  }
  EXPECT_NEAR(twice.common_scale_std / small.common_scale_std, 1.0, 0.02);
  // Nothing but the file fixes the scale: what all lengths have in common stays as unsure.
  EXPECT_NEAR(small.common_scale_std / small.common_scale_std_before, 1.0, 0.1);
}

TEST(LearnSite, WhatIsKnownStaysKnown) {
  Scene scene = scene_of(6, 4);
  scene.stated.camera->roll_rad = scene.truth.site.camera->roll_rad;
  scene.stated.lamps.separation_m->std = 0.0;
  const SiteLearning learning = learning_of(scene);
  EXPECT_EQ(learning.site.camera->roll_rad, scene.stated.camera->roll_rad);
  EXPECT_EQ(learning.site.lamps.separation_m, scene.stated.lamps.separation_m);
  for (const LearnedQuantity& one : learning.quantities) {
    EXPECT_NE(one.key, "camera.roll_deg");
    EXPECT_NE(one.key, "lamps.separation_m");
  }
}

TEST(LearnSite, AFocalLengthThatIsOffIsInTheSigmasOfTheAngles) {
  // Two of its sigmas off. Angles come out smaller by the share that a focal length is greater.
  constexpr double kStd = 0.01;
  Scene scene = scene_of(12, 6);
  CameraSite& stated = *scene.stated.camera;
  stated.focal_std_px = kStd * stated.focal_px[0];
  for (double& focal_px : stated.focal_px) focal_px *= 1.0 + 2.0 * kStd;
  const SiteLearning learning = learning_of(scene);
  const CameraSite &learned = *learning.site.camera, &truth = *scene.truth.site.camera;
  constexpr double kSigmas = 3.0;
  EXPECT_LT(std::abs(learned.pitch_rad.mean - truth.pitch_rad.mean),
            kSigmas * learned.pitch_rad.std);
  EXPECT_LT(std::abs(learned.yaw_rad.mean - truth.yaw_rad.mean), kSigmas * learned.yaw_rad.std);
  EXPECT_LT(std::abs(learned.focal_px[0] - truth.focal_px[0]), kSigmas * learned.focal_std_px);
  EXPECT_LE(learned.focal_std_px, stated.focal_std_px);
  EXPECT_DOUBLE_EQ(learned.focal_px[1] / learned.focal_px[0],
                   stated.focal_px[1] / stated.focal_px[0]);
  const LearnedQuantity& focal = quantity(learning, "camera.focal_px");
  EXPECT_DOUBLE_EQ(focal.before.mean, stated.focal_px[0]);
  EXPECT_DOUBLE_EQ(focal.before.std, stated.focal_std_px);
  EXPECT_DOUBLE_EQ(focal.after.std, learned.focal_std_px);
}

TEST(LearnSite, SaysThatASiteFileIsStrainedWhereItIsWrong) {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6})
    EXPECT_FALSE(learning_of(scene_of(16, seed)).strains_the_file()) << seed;
  // Lamps wider apart than any here, which all other lengths deny.
  Scene scene = scene_of(16, 7);
  scene.stated.lamps.separation_m = Uncertain{1.6, 0.12};
  const SiteLearning learning = learning_of(scene);
  EXPECT_LT(quantity(learning, "lamps.separation_m").strain, -3.5);
  EXPECT_TRUE(learning.strains_the_file());
  EXPECT_FALSE(learning.denied());
  scene.stated.lamps.separation_m = Uncertain{1.7, 0.12};
  const auto denied = learning_of(scene).denied();
  ASSERT_TRUE(denied);
  EXPECT_EQ(denied->key, "lamps.separation_m");
}

TEST(LearnSite, PassesOfAnotherCameraTakeNoPart) {
  Scene scene = scene_of(8, 8);
  Scene other = scene;
  other.stated.camera->position_m[2].mean = 1.5;
  Random random(9);
  const auto truth = simulated::true_site(other.stated, random);
  for (const VehicleTrack& track :
       simulated::tracks_of(simulated::passes_of(truth, 6, 15.0, random)))
    scene.tracks.push_back(track);
  const SiteLearning learning = learning_of(scene);
  EXPECT_EQ(learning.took_part, (std::vector<std::size_t>{0, 1, 2, 3, 4, 5, 6, 7}));
}

TEST(LearnSite, FewPassesTellNothing) {
  const Scene scene = scene_of(4, 5);
  EXPECT_EQ(std::get<Miss>(learn_site(scene.tracks, scene.stated)), Miss::too_few_samples);
  EXPECT_EQ(std::get<Miss>(learn_site({}, scene.stated)), Miss::too_few_samples);
  Site dashcam = scene.stated;
  dashcam.ego = EgoSite{{15.0, 0.3}, {}, {}};
  EXPECT_THROW(learn_site(scene.tracks, dashcam), std::invalid_argument);
}

}  // namespace
}  // namespace vildar
