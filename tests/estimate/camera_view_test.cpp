#include "estimate/camera_view.h"

#include <gtest/gtest.h>

#include "simulated_pass.h"

namespace vildar {
namespace {

// The light of one lamp is fitted, and of the other only a bound is known.
TEST(Intensity, OfAPairIsABoundWhereOneLampsIs) {
  Random random(1);
  const Site site = simulated::mast_site(4.0);
  VehicleTrack track = simulated::track_of({}, site, {}, random);
  VehicleSighting& seen = track.sightings.front();
  for (LampSighting* lamp : {&*seen.left, &*seen.right}) {
    lamp->defects = Defect::saturated;
    lamp->flux = 100.0;
    lamp->flux_sigma = 2.0;
    lamp->lamp = LampLight{1000.0, 20.0};
  }
  const Camera camera(*site.camera);
  TrackRow row = bearing_rows(track, camera, site).front();
  EXPECT_DOUBLE_EQ(row.intensity, 2000.0);
  EXPECT_NEAR(row.intensity_std, 28.3, 0.1);
  seen.right->lamp.reset();
  row = bearing_rows(track, camera, site).front();
  EXPECT_DOUBLE_EQ(row.intensity, 1100.0);
  EXPECT_DOUBLE_EQ(row.intensity_std, 1100.0);
  seen.right->lamp = LampLight{1000.0, 20.0};
  seen.left->defects = Defect::cut_by_edge;
  EXPECT_DOUBLE_EQ(bearing_rows(track, camera, site).front().intensity_std, 2000.0);
}

}  // namespace
}  // namespace vildar
