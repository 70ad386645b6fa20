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

}  // namespace
}  // namespace vildar
