#include <gtest/gtest.h>

#include "support/program.h"

namespace vildar {
namespace {

// A mast that sways by 0.15 degrees up and down, beside street lamps; four cars.
constexpr std::string_view kScenario = R"(
duration_s: 12.5
frame_rate_hz: 20
seed: 5
shake: {yaw_std_deg: 0.1, pitch_std_deg: 0.15, frequency_hz: 2.5}
site:
  camera:
    image_size_px: [640, 360]
    focal_px: [540.0, 540.0]
    principal_px: [319.5, 179.5]
    position_m: [0.0, 0.0, 5.0]
    yaw_deg: -6.0
    pitch_deg: -5.0
    roll_deg: 0.0
    exposure_s: 0.001
  road:
    kind: straight
    lanes:
      - {id: near, lateral_m: -3.0, width_m: 3.5, direction: oncoming}
      - {id: middle, lateral_m: -6.5, width_m: 3.5, direction: oncoming}
  lamps:
    height_m: {mean: 0.65, std: 0.06}
    separation_m: {mean: 1.30, std: 0.08}
vehicles:
  - {id: v0, kind: car, lane: near, speed_mps: 21.6, range_at_zero_m: 66, lamp_height_m: 0.67, lamp_separation_m: 1.33, intensity_cd: 800}
  - {id: v1, kind: car, lane: middle, speed_mps: 16.1, range_at_zero_m: 93, lamp_height_m: 0.62, lamp_separation_m: 1.25, intensity_cd: 800}
  - {id: v2, kind: car, lane: near, speed_mps: 14.3, range_at_zero_m: 121, lamp_height_m: 0.66, lamp_separation_m: 1.28, intensity_cd: 800}
  - {id: v3, kind: car, lane: middle, speed_mps: 18.4, range_at_zero_m: 201, lamp_height_m: 0.70, lamp_separation_m: 1.36, intensity_cd: 800}
street_lamps:
  - {position_m: [55.0, 6.0, 8.0], intensity_cd: 900}
  - {position_m: [95.0, -14.0, 8.0], intensity_cd: 900}
  - {position_m: [75.0, 6.0, 8.0], intensity_cd: 900}
  - {position_m: [60.0, -14.0, 8.0], intensity_cd: 900}
)";

// The street lamps tell how the camera turns: bearings are then good to a small part of its 2 mrad,
// and no vehicle is lost to the shaking.
TEST(ShakenClip, IsMeasuredAgainstTheLightsThatStand) {
  const TemporaryFolder folder;
  const auto path = [&](const char* name) { return (folder.path() / name).string(); };
  const auto run = [&](const std::vector<std::string>& arguments) {
    return test::Program(VILDAR_PROGRAM, arguments, folder.path()).wait();
  };
  folder.write("scenario.yaml", kScenario);
  ASSERT_EQ(run({"render", path("scenario.yaml"), "--out", path("scene")}).code, 0);
  ASSERT_EQ(
      run({"run", path("scene/clip.mp4"), "--site", path("scene/site.yaml"), "--out", path("run")})
          .code,
      0);
  const test::Ran score = run({"evaluate", path("run"), path("scene"), "--require", "recall==1",
                               "--require", "false==0", "--require", "azimuth_rms_rad<=0.0006",
                               "--require", "share_within_limits==1"});
  EXPECT_EQ(score.code, 0) << score.err << score.out;
}

}  // namespace
}  // namespace vildar
