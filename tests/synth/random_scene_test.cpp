#include "synth/random_scene.h"

#include <cmath>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "synth/random_site.h"
#include "synth/scenario.h"
#include "synth/truth.h"

namespace vildar {
namespace {

constexpr ScenePreset kAll[] = {ScenePreset::straight, ScenePreset::three_lanes, ScenePreset::curve,
                                ScenePreset::dashcam,  ScenePreset::photodiode,  ScenePreset::wet,
                                ScenePreset::survey};

Scenario loaded(const std::string& text) {
  const std::filesystem::path file =
      std::filesystem::path(::testing::TempDir()) / "random_scene_test.yaml";
  std::ofstream(file) << text;
  return load_scenario(file);
}

TEST(RandomScene, EveryFamilyLoadsAndShowsVehicles) {
  for (const ScenePreset preset : kAll)
    for (std::uint64_t index = 1; index <= 4; ++index) {
      const Scenario scenario = loaded(random_scenario_yaml(preset, 3, index));
      ASSERT_TRUE(scenario.told_site);
      ASSERT_FALSE(scenario.vehicles.empty());
      EXPECT_FALSE(truth_tracks(scenario).empty());
      EXPECT_EQ(scenario.site.camera.has_value(), preset != ScenePreset::photodiode);
    }
}

TEST(RandomScene, SameSeedSameTextOthersOther) {
  const std::string text = random_scenario_yaml(ScenePreset::curve, 5, 2);
  EXPECT_EQ(random_scenario_yaml(ScenePreset::curve, 5, 2), text);
  EXPECT_NE(random_scenario_yaml(ScenePreset::curve, 5, 3), text);
  EXPECT_NE(random_scenario_yaml(ScenePreset::curve, 6, 2), text);
}

TEST(RandomScene, TheTruthIsDrawnFromWhatIsTold) {
  constexpr int kScenes = 400;
  struct Spread {
    double sum = 0.0, square = 0.0;
    int count = 0;
    void add(double sigmas) {
      sum += sigmas;
      square += sigmas * sigmas;
      ++count;
    }
  } pitch, height, separation, place, gain;
  const auto sigmas = [](double truth, const Uncertain& told) {
    return (truth - told.mean) / told.std;
  };
  for (int i = 0; i < kScenes; ++i) {
    const Scenario scene =
        loaded(random_scenario_yaml(ScenePreset::straight, 11, static_cast<std::uint64_t>(i)));
    const Site& told = *scene.told_site;
    EXPECT_EQ(scene.site.camera->pitch_rad.std, 0.0);
    pitch.add(sigmas(scene.site.camera->pitch_rad.mean, told.camera->pitch_rad));
    const VehicleScene& vehicle = scene.vehicles.front();
    height.add(sigmas(vehicle.lamp_height_m, *told.lamps.height_m));
    if (vehicle.lamp_separation_m > 0.0)
      separation.add(sigmas(vehicle.lamp_separation_m, *told.lamps.separation_m));
    place.add(vehicle.lateral_offset_m / (3.5 / 12.0));
    gain.add(10.0 * std::log10(vehicle.power_ratio) / told.channel->gain_db->std);
  }
  for (const Spread& spread : {pitch, height, separation, place, gain}) {
    const double count = spread.count;
    EXPECT_NEAR(spread.sum / count, 0.0, 4.5 / std::sqrt(count));
    EXPECT_NEAR(spread.square / count, 1.0, 4.5 * std::sqrt(2.0 / count));
  }
}

TEST(PresetOf, KnowsItsNames) {
  EXPECT_EQ(preset_of("three-lanes"), ScenePreset::three_lanes);
  EXPECT_FALSE(preset_of("four-lanes"));
  EXPECT_NE(preset_names().find("dashcam, photodiode"), std::string::npos);
}

}  // namespace
}  // namespace vildar
