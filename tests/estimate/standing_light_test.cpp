#include <gtest/gtest.h>

#include "estimate/vehicle.h"
#include "simulated_pass.h"

namespace vildar {
namespace {

// A dashcam that drives at 15 m/s towards a light between its lane and the next one.
class ByTheRoad : public ::testing::Test {
 protected:
  ByTheRoad() {
    site_.camera->position_m[2] = {1.3, 0.03};
    site_.road.lanes = {{"own", {0.0, 0.3}, 3.5, Direction::receding},
                        {"next", {3.5, 0.3}, 3.5, Direction::oncoming}};
    site_.ego = EgoSite{};
    site_.ego->speed_mps = {15.0, 0.2};
  }
  VehicleResult measured(double speed_mps) {
    const simulated::Vehicle light{speed_mps, 0.0, 60.0, 2.1, 0.75, 0.0};
    VehicleTrack track = simulated::track_of(
        light, site_, {.from_s = 0.0, .to_s = 3.0, .single_lamp = true, .ego_mps = 15.0}, random_);
    return estimate_vehicle(track, site_, {}).result;
  }

  Random random_{5};
  Site site_ = simulated::mast_site(1.3);
};

TEST_F(ByTheRoad, AReflectorIsNoVehicle) { EXPECT_EQ(measured(0.0).withheld, Miss::too_uncertain); }

TEST_F(ByTheRoad, AMotorcycleThatComesIs) {
  const VehicleResult result = measured(15.0);
  ASSERT_FALSE(result.withheld) << name_of(*result.withheld);
  EXPECT_LT(std::abs(result.speed.speed_mps - 15.0), 3.0 * result.speed.std_mps);
}

}  // namespace
}  // namespace vildar
