#include <cmath>

#include "core/quantity.h"
#include "geometry_pass.h"
#include "support/trials.h"

namespace vildar {
namespace {

struct Weaving {
  int measured = 0, inside = 0;
  double squares = 0.0;
  double stated2 = 0.0;  // relative
};

// Cars that slow down evenly on a straight road and go some centimetres to and fro within their
// lane.
Weaving weaving(double camera_height_m, double weave_m, int cars, double sigma_px = 0.1) {
  Weaving found;
  for (int i = 0; i < cars; ++i) {
    Random random(static_cast<std::uint64_t>(20261129 + i));
    Site site = simulated::mast_site(camera_height_m);
    site.camera->pitch_rad.std = site.camera->yaw_rad.std = 0.001;
    const auto [height_m, separation_m] = std::pair(*site.lamps.height_m, *site.lamps.separation_m);
    simulated::Vehicle car;
    car.speed_mps = random.uniform(9.0, 16.0);
    car.acceleration_mps2 = -0.7;
    car.along_m = random.uniform(70.0, 90.0);
    car.height_m = height_m.mean + height_m.std * random.normal();
    car.separation_m = separation_m.mean + separation_m.std * random.normal();
    car.weave = {weave_m, random.uniform(3.0, 7.0), random.uniform(0.0, 2.0 * kPi)};
    simulated::View view;
    view.sigma_px = sigma_px;
    view.to_s = 4.5;
    const VehicleResult result =
        estimate_vehicle(simulated::track_of(car, site, view, random), site, {}).result;
    if (result.withheld) continue;
    const double speed_mps = car.speed_at_mps(result.speed.time_s);
    const double sigmas = (result.speed.speed_mps - speed_mps) / result.speed.std_mps;
    ++found.measured;
    found.inside += result.speed.lo95_mps <= speed_mps && speed_mps <= result.speed.hi95_mps;
    found.squares += sigmas * sigmas;
    found.stated2 += std::pow(result.speed.std_mps / speed_mps, 2);
  }
  return found;
}

// From low down the bearing across the road tells the range, and a weave looks like braking.
TEST(Weave, OfADriverIsNoBraking) {
  constexpr int kCars = trials(80);
  const Weaving cars = weaving(1.5, 0.08, kCars);
  EXPECT_GE(cars.measured, 0.95 * kCars);
  EXPECT_GE(cars.inside, 0.88 * cars.measured);
  EXPECT_LT(std::sqrt(cars.squares / cars.measured), 1.25);
}

// From a mast a weave is not taken for all that a fit leaves: sigmas of 3.2 %.
TEST(Weave, BeforeAMastIsNoNoise) {
  constexpr int kCars = trials(60);
  const Weaving cars = weaving(6.0, 0.08, kCars, 0.03);
  EXPECT_GE(cars.measured, 0.95 * kCars);
  EXPECT_GE(cars.inside, 0.88 * cars.measured);
  EXPECT_LT(std::sqrt(cars.squares / cars.measured), 1.25);
  EXPECT_LT(std::sqrt(cars.stated2 / cars.measured), 0.022);
}

}  // namespace
}  // namespace vildar
