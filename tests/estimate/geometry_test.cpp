#include <gtest/gtest.h>

#include "estimate/vehicle.h"
#include "simulated_pass.h"

namespace vildar {
namespace {

using simulated::mast_site;
using simulated::track_of;
using simulated::Vehicle;
using simulated::View;

VehicleResult result_of(const Vehicle& vehicle, const Site& site, const View& view,
                        Random& random) {
  return estimate_vehicle(track_of(vehicle, site, view, random), site, {}).result;
}

TEST(Geometry, RecoversTheMotionWithoutNoise) {
  Random random(1);
  Site site = mast_site(4.0);
  site.camera->rolling_shutter_s = 0.02;
  site.camera->yaw_rad.mean = 0.05;
  site.camera->roll_rad.mean = -0.03;
  const Vehicle vehicle{20.0, 1.0, 62.0, -4.0, 0.65, 1.2};
  const View view{.sigma_px = 1e-6};
  const VehicleResult result = result_of(vehicle, site, view, random);
  ASSERT_FALSE(result.withheld) << name_of(*result.withheld);
  const double t_s = result.speed.time_s;
  EXPECT_NEAR(result.speed.speed_mps / vehicle.speed_at_mps(t_s), 1.0, 1e-3);
  EXPECT_NEAR(*result.range_ref_m / vehicle.along_at_m(t_s), 1.0, 1e-3);
  EXPECT_EQ(result.lane, "near");
}

}  // namespace
}  // namespace vildar
