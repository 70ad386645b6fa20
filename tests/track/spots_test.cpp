#include "track/spots.h"

#include <gtest/gtest.h>

#include "scene.h"

namespace vildar {
namespace {

Blob blob_in(const PixelBox& box) {
  Blob blob;
  blob.kind = LampKind::headlamp;
  blob.box = box;
  blob.centre_px = {0.5 * (box.u_min + box.u_max), 0.5 * (box.v_min + box.v_max)};
  blob.centre_sigma_px = {0.1, 0.1};
  return blob;
}

double height_sigma_px(const std::vector<Blob>& blobs) {
  const RoadView view(scene::site_of(5.0, -6.0, 1400.0, 1920, 1080));
  return spots_of({0, CameraTime{}, blobs}, view).front().centre_sigma_px.y();
}

TEST(Spots, ALampIsLessSureOfItsHeightWhereLightHangsBelowIt) {
  const Blob lamp = blob_in({1000, 600, 1007, 607});
  constexpr double kAlone_px = 0.1, kQuarterOfWidth_px = 2.0;
  EXPECT_NEAR(height_sigma_px({lamp}), kAlone_px, 1e-9);
  EXPECT_NEAR(height_sigma_px({lamp, blob_in({1001, 609, 1006, 614})}),
              std::hypot(kAlone_px, kQuarterOfWidth_px), 1e-9);
  // Farther down, above, or in other columns: nothing hangs there.
  for (const PixelBox& apart : {PixelBox{1001, 612, 1006, 617}, PixelBox{1001, 590, 1006, 598},
                                PixelBox{1009, 609, 1014, 614}})
    EXPECT_NEAR(height_sigma_px({lamp, blob_in(apart)}), kAlone_px, 1e-9) << apart.u_min;
}

// Headlamp and fog lamp, each 10 px wide, clip as one light of 10 x 15.
TEST(Spots, ALampThatClipsTogetherWithOneBelowItIsAtTheTop) {
  Site site = scene::site_of(5.0, -6.0, 1400.0, 1920, 1080);
  Blob both = blob_in({1000, 600, 1009, 614});
  both.saturated_px = 120;
  const auto seen = [&](const Blob& blob, double exposure_s) {
    site.camera->exposure_s = exposure_s;
    return spots_of({0, CameraTime{}, {blob}}, RoadView(site)).front();
  };
  const Spot spot = seen(both, 0.001);
  EXPECT_NEAR(spot.centre_px.y(), 604.5, 1e-9);
  EXPECT_NEAR(spot.centre_sigma_px.y(), std::hypot(0.1, 2.5), 1e-9);
  EXPECT_NEAR(spot.centre_sigma_px.x(), std::hypot(0.1, 1.0), 1e-9);
  EXPECT_FALSE(spot.casts_image);
  // A lamp may be drawn out that far in a long exposure, and one whose lower part does not clip has
  // its image on a wet road there.
  EXPECT_NEAR(seen(both, 0.04).centre_px.y(), both.centre_px.y(), 1e-9);
  both.saturated_px = 70;
  EXPECT_NEAR(seen(both, 0.001).centre_px.y(), both.centre_px.y(), 1e-9);
}

// A lamp 90 m away, 5 px wide, whose own image on the road makes one blob of 5 x 31 with it. The
// image of a lamp 40 m farther on ends above that blob's middle.
TEST(Spots, ALampWithItsStreakIsNoStreakOfALampFartherOn) {
  const Site site = scene::site_of(5.0, -6.0, 1400.0, 1920, 1080);
  const RoadView view(site);
  const Camera camera(*site.camera);
  const auto pixel_at = [&](double range_m) {
    return *camera.project({range_m, -4.0, view.lamp_height_m()});
  };
  const auto blob_at = [&](const Eigen::Vector2d& lamp_px, int height_px) {
    const int u = static_cast<int>(lamp_px.x()), v = static_cast<int>(lamp_px.y());
    return blob_in({u - 2, v - 2, u + 2, v - 2 + height_px - 1});
  };
  const Eigen::Vector2d near_px = pixel_at(90.0), far_px = pixel_at(130.0);
  const std::vector<Spot> spots =
      spots_of({0, CameraTime{}, {blob_at(far_px, 5), blob_at(near_px, 31)}}, view);
  EXPECT_FALSE(spots[1].streak);
  EXPECT_NEAR(spots[1].centre_px.y(), near_px.y(), 1.0);
  EXPECT_FALSE(spots[0].casts_image);
  EXPECT_TRUE(spots[1].casts_image);
  // Its own image, parted from the lamp, is one.
  const double drop_px = 2.0 * view.lamp_height_m() / 90.0 * 1400.0;
  const Eigen::Vector2d image_px = near_px + Eigen::Vector2d(0.0, drop_px - 8.0);
  const std::vector<Spot> parted =
      spots_of({0, CameraTime{}, {blob_at(near_px, 5), blob_at(image_px, 20)}}, view);
  EXPECT_TRUE(parted[0].casts_image);
  EXPECT_TRUE(parted[1].streak);
  EXPECT_FALSE(parted[1].casts_image);
}

}  // namespace
}  // namespace vildar
