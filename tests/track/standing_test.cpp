#include "track/standing.h"

#include <cmath>

#include <gtest/gtest.h>

#include "one_car.h"
#include "scene.h"

namespace vildar {
namespace {

using Road = scene::OneCar;

// A camera in a hand: degrees, at 0.3 to 0.6 Hz.
Eigen::Vector3d swayed_rad(double t_s) {
  const double turn_rad = 2.0 * kPi * t_s;
  return {0.018 * std::sin(0.37 * turn_rad) + 0.009 * std::sin(0.61 * turn_rad + 1.0),
          0.018 * std::sin(0.29 * turn_rad + 2.0) + 0.009 * std::sin(0.53 * turn_rad),
          0.008 * std::sin(0.33 * turn_rad + 0.5)};
}

scene::Scene held_by_hand() {
  scene::Scene made;
  made.site = scene::site_of(1.6, -1.0, 1024.0, 1280, 720);
  made.site.camera->yaw_rad.mean = 0.1;
  made.site.camera->yaw_rad.std = made.site.camera->pitch_rad.std = 0.08;
  made.street_lamps = {{25.0, 11.0, 7.5}, {55.0, 11.0, 7.5}, {85.0, 11.0, 7.5}};
  scene::Car car;
  car.x_m = 90.0;
  car.y_m = 4.0;
  car.speed_mps = -8.0;
  made.cars = {car};
  made.frame_rate_hz = 30.0;
  made.duration_s = 8.0;
  made.turned_rad = swayed_rad;
  return made;
}

TEST(Standing, TheTurnsOfACameraInAHandAreToldByThreeStreetLamps) {
  const scene::Scene made = held_by_hand();
  const auto outcome = scene::run(made);
  int told = 0;
  Eigen::Vector3d mean_rad = Eigen::Vector3d::Zero();
  const auto off_rad = [&](std::size_t k) -> Eigen::Vector3d {
    return outcome.turns[k]->rotation_rad - swayed_rad(static_cast<double>(k) / made.frame_rate_hz);
  };
  for (std::size_t k = 0; k < outcome.turns.size(); ++k)
    if (outcome.turns[k]) {
      ++told;
      mean_rad += off_rad(k);
    }
  ASSERT_GE(told, 0.95 * static_cast<double>(outcome.turns.size()));
  mean_rad /= told;
  // Relative to the mean pose: 0.15 px of noise in each of three lights.
  double square = 0.0;
  for (std::size_t k = 0; k < outcome.turns.size(); ++k)
    if (outcome.turns[k]) square += (off_rad(k) - mean_rad).head<2>().squaredNorm();
  EXPECT_LT(std::sqrt(square / told), 1.0 / 1024.0);
}

TEST(Standing, LampsThatComeNearerDoNotThoughTheCameraSways) {
  const Road road;
  Lamps lamps;
  for (const double y_m : {-4.0, -9.0})
    for (const double ahead_m : {0.0, 20.0})
      lamps.push_back(std::make_unique<Lamp>(road.lamp(0, 75, y_m, ahead_m)));
  for (const auto& lamp : lamps) EXPECT_FALSE(stands_in_the_world(*lamp, lamps, road.view, true));
}

}  // namespace
}  // namespace vildar
