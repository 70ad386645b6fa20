#include "track/lamp_parts.h"

#include <gtest/gtest.h>

#include <numbers>

#include "scene.h"

namespace vildar {
namespace {

constexpr double kFocal_px = 1500.0;

Site site_at(double height_m) { return scene::site_of(height_m, -4.0, kFocal_px, 1920, 1080); }

Blob light_at(const Eigen::Vector2d& centre_px, double flux = 100.0) {
  Blob blob;
  blob.kind = LampKind::taillamp;
  blob.centre_px = centre_px;
  blob.box = {static_cast<int>(centre_px.x()) - 1, static_cast<int>(centre_px.y()) - 1,
              static_cast<int>(centre_px.x()) + 1, static_cast<int>(centre_px.y()) + 1};
  blob.flux = flux;
  return blob;
}

/// Where a light is seen that stands `depth_m` ahead, at the height and place across the road.
Eigen::Vector2d pixel_of(const Site& site, double depth_m, double lateral_m, double height_m) {
  return *Camera(*site.camera).project({depth_m, lateral_m, height_m});
}

BlobFrame joined(std::vector<Blob> blobs, const Site& site) {
  BlobFrame frame{0, CameraTime{}, std::move(blobs)};
  join_lamp_parts(frame, RoadView(site));
  return frame;
}

// Eight LEDs on a circle of 0.2 m, 30 m before a mast.
TEST(LampParts, ARingOfLedsIsOneLampAtItsMiddle) {
  const Site site = site_at(5.0);
  const Eigen::Vector2d middle_px = pixel_of(site, 30.0, -3.0, 0.75);
  constexpr int kLeds = 8;
  constexpr double kRadius_px = 0.1 / 30.0 * kFocal_px;
  std::vector<Blob> blobs{light_at({300.0, 200.0}), light_at({700.0, 900.0})};
  for (int i = 0; i < kLeds; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kLeds;
    blobs.push_back(
        light_at(middle_px + kRadius_px * Eigen::Vector2d(std::cos(angle), std::sin(angle))));
  }
  const BlobFrame frame = joined(blobs, site);
  ASSERT_EQ(frame.blobs.size(), 3u);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(frame.blobs[static_cast<std::size_t>(i)].id, i);
  const Blob& ring = frame.blobs.back();
  EXPECT_NEAR((ring.centre_px - middle_px).norm(), 0.0, 1e-9);
  EXPECT_NEAR(ring.flux, 100.0 * kLeds, 1e-9);
  EXPECT_NEAR(ring.spread_px.x(), kRadius_px * std::numbers::sqrt2 / 2.0, 1e-9);
  EXPECT_LE(ring.box.u_min, middle_px.x() - kRadius_px);
  EXPECT_GE(ring.box.v_max, middle_px.y() + kRadius_px - 1.0);
}

TEST(LampParts, TheCentreIsThatOfTheLight) {
  const Site site = site_at(5.0);
  const Eigen::Vector2d at_px = pixel_of(site, 30.0, -3.0, 0.75);
  const BlobFrame frame =
      joined({light_at(at_px, 300.0), light_at(at_px + Eigen::Vector2d(4.0, 0.0), 100.0)}, site);
  ASSERT_EQ(frame.blobs.size(), 1u);
  EXPECT_NEAR(frame.blobs[0].centre_px.x(), at_px.x() + 1.0, 1e-9);
}

TEST(LampParts, TwoLampsStayTwo) {
  const Site site = site_at(5.0);
  for (const double depth_m : {15.0, 40.0, 120.0}) {
    const Blob left = light_at(pixel_of(site, depth_m, -2.4, 0.75));
    Blob right = light_at(pixel_of(site, depth_m, -3.6, 0.75));
    EXPECT_EQ(joined({left, right}, site).blobs.size(), 2u) << depth_m;
  }
  // Near enough to be parts of one, but for their colour, or because one clips above the other.
  const Eigen::Vector2d at_px = pixel_of(site, 30.0, -3.0, 0.75);
  const Blob part = light_at(at_px);
  Blob other = light_at(at_px + Eigen::Vector2d(4.0, 0.0));
  ASSERT_EQ(joined({part, other}, site).blobs.size(), 1u);
  other.kind = LampKind::headlamp;
  EXPECT_EQ(joined({part, other}, site).blobs.size(), 2u);
  other.kind = LampKind::other;
  EXPECT_EQ(joined({other, other}, site).blobs.size(), 2u);
  other.kind = LampKind::taillamp;
  other.saturated_px = 9;
  EXPECT_EQ(joined({part, other}, site).blobs.size(), 1u);
  other.centre_px = at_px + Eigen::Vector2d(0.0, 4.0);
  EXPECT_EQ(joined({part, other}, site).blobs.size(), 2u);
}

TEST(LampParts, AMotorcyclesTwoHeadlampsAreOne) {
  const Site site = site_at(5.0);
  Blob left = light_at(pixel_of(site, 20.0, -2.89, 0.75));
  Blob right = light_at(pixel_of(site, 20.0, -3.11, 0.75));
  left.kind = right.kind = LampKind::headlamp;
  const BlobFrame frame = joined({left, right}, site);
  ASSERT_EQ(frame.blobs.size(), 1u);
  EXPECT_EQ(frame.blobs[0].kind, LampKind::headlamp);
  EXPECT_NEAR(frame.blobs[0].centre_px.x(), 0.5 * (left.centre_px.x() + right.centre_px.x()), 1e-9);
  right.flux *= 0.3;
  EXPECT_EQ(joined({left, right}, site).blobs.size(), 2u) << "an indicator";
}

// Five LEDs 0.2 m apart are wider than a lamp.
TEST(LampParts, ARowOfLightsWiderThanALampIsNotOne) {
  const Site site = site_at(5.0);
  std::vector<Blob> blobs;
  for (int i = 0; i < 5; ++i) blobs.push_back(light_at(pixel_of(site, 20.0, -3.0 - 0.2 * i, 0.75)));
  const BlobFrame frame = joined(blobs, site);
  EXPECT_GT(frame.blobs.size(), 1u);
  for (const Blob& blob : frame.blobs)
    EXPECT_LT(blob.box.u_max - blob.box.u_min, 0.5 / 20.0 * kFocal_px);
}

// From a dashboard the elevation of lamps hardly tells their depth. Here the camera looks up by
// more than the site says: 300 m off a pair of 6 px stands as low as at 60 m, where that were 0.24
// m.
TEST(LampParts, AFarPairBeforeALowCameraStaysAPair) {
  Site told = site_at(1.0);
  told.camera->pitch_rad.std = 0.003;
  told.lamps.height_m = Uncertain{0.75, 0.1};
  Site truth = told;
  truth.camera->pitch_rad.mean += 0.0035;
  const Blob left = light_at(pixel_of(truth, 300.0, -2.4, 0.75));
  const Blob right = light_at(pixel_of(truth, 300.0, -3.6, 0.75));
  EXPECT_EQ(joined({left, right}, told).blobs.size(), 2u);
}

}  // namespace
}  // namespace vildar
