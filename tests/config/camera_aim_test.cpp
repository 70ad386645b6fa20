#include <cmath>

#include <gtest/gtest.h>

#include "config/site_file.h"
#include "config/site_text.h"
#include "core/quantity.h"
#include "support/temporary_folder.h"

namespace vildar {
namespace {

TEST(CameraAim, AnAngleOfTheCameraLeftOutIsUnknownAndNotZero) {
  const TemporaryFolder folder;
  const std::string angles = "  yaw_deg: 0.0\n  pitch_deg: -4.0\n  roll_deg: 0.0\n";
  const Site site = load_site(folder.write("site.yaml", with(kContractSite, angles, "")));
  // One that stands looks at the lanes, at -4 and -7.5 m, 40 m ahead; a dashcam is level.
  EXPECT_DOUBLE_EQ(site.camera->yaw_rad.mean, std::atan2(-5.75, 40.0));
  EXPECT_DOUBLE_EQ(site.camera->yaw_rad.std, 5.0 * kDegree);
  EXPECT_DOUBLE_EQ(site.camera->pitch_rad.mean, -std::atan2(5.0, 40.0));
  EXPECT_DOUBLE_EQ(site.camera->pitch_rad.std, 4.0 * kDegree);
  EXPECT_EQ(site.camera->roll_rad, (Uncertain{0.0, 2.0 * kDegree}));
  const std::string driven =
      with(with(kContractSite, angles, ""), "speed_mps: 0.0  ", "speed_mps: 15.0 ");
  const Site dashcam = load_site(folder.write("driven.yaml", driven));
  EXPECT_EQ(dashcam.camera->yaw_rad, (Uncertain{0.0, 5.0 * kDegree}));
  EXPECT_EQ(dashcam.camera->pitch_rad, (Uncertain{0.0, 5.0 * kDegree}));
}

// From 25 m up the road 20 m ahead lies 51 degrees down, that 100 m ahead 14.
TEST(CameraAim, FromHighUpTheAimIsLessSure) {
  const TemporaryFolder folder;
  std::string text = with(kContractSite, "  pitch_deg: -4.0\n", "");
  text = with(text, "position_m: [0.0, 0.0, 5.0] ", "position_m: [0.0, 0.0, 25.0] ");
  const Site site = load_site(folder.write("site.yaml", text));
  EXPECT_NEAR(site.camera->pitch_rad.std, 0.25 * (std::atan(1.25) - std::atan(0.25)), 1e-12);
}

TEST(CameraAim, ACameraNotToldWhereLooksIntoTheBend) {
  const TemporaryFolder folder;
  std::string text = with(kContractSite, "  yaw_deg: 0.0\n  pitch_deg: -4.0", "  pitch_deg: -4.0");
  text = with(text, "kind: straight ", "kind: curved ");
  const Site site = load_site(folder.write("site.yaml", text));
  // 40 m of the lanes' own path on a circle about (0, 40), to the left.
  const double radius_m = 40.0 + 5.75, turned_rad = 40.0 / radius_m;
  EXPECT_NEAR(site.camera->yaw_rad.mean,
              std::atan2(40.0 - radius_m * std::cos(turned_rad), radius_m * std::sin(turned_rad)),
              1e-12);
}

}  // namespace
}  // namespace vildar
