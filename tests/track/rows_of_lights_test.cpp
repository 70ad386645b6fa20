#include <gtest/gtest.h>

#include "made_scenes.h"

namespace vildar {
namespace {

using namespace scene;

// Over the cab of a lorry whose headlamps another vehicle hides.
TEST(RowsOfLights, APairInOneSaysThatOthersStandBetween) {
  for (const bool row : {false, true}) {
    Scene made = tower();
    made.cars = {car(75, -4, -12)};
    made.cars[0].height_m = 3.0;
    made.cars[0].separation_m = 2.0;
    for (const double aside_m : {-0.5, 0.0, 0.5}) {
      if (!row) continue;
      made.cars.push_back(car(75, -4 + aside_m, -12));
      made.cars.back().height_m = 3.0;
      made.cars.back().single = true;
    }
    const auto outcome = run(made);
    int pairs = 0;
    for (const VehicleTrack& track : outcome.tracks) {
      if (track.single_lamp) continue;
      ++pairs;
      EXPECT_EQ(track.lights_between, row);
    }
    EXPECT_EQ(pairs, 1);
  }
}

}  // namespace
}  // namespace vildar
