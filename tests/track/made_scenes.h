#pragma once

#include <gtest/gtest.h>

#include "scene.h"

namespace vildar::scene {

inline Scene mast() {
  Scene made;
  made.site = site_of(5.0, -4.0, 1400.0, 1920, 1080);
  return made;
}

inline Scene dashcam(double ego_mps) {
  Scene made;
  made.site = site_of(1.3, 0.0, 1000.0, 1280, 720);
  made.site.ego = EgoSite{Uncertain{ego_mps, 0.5}, {}, {}};
  return made;
}

inline Scene tower() {
  Scene made;
  made.site = site_of(20.0, -20.0, 600.0, 480, 360);
  made.resolution_px = 3.0;
  return made;
}

inline Car car(double x_m, double y_m, double speed_mps, LampKind kind = LampKind::headlamp) {
  Car one;
  one.x_m = x_m;
  one.y_m = y_m;
  one.speed_mps = speed_mps;
  one.kind = kind;
  return one;
}

// One pure track for each car and no other track.
inline void expect_each_car_once(const Outcome& outcome, std::size_t cars, double least_recall) {
  EXPECT_EQ(outcome.tracks.size(), cars);
  for (std::size_t i = 0; i < outcome.tracks.size(); ++i)
    EXPECT_TRUE(outcome.car_of(i)) << "track " << outcome.tracks[i].id << " holds several lights";
  for (int c = 0; c < static_cast<int>(cars); ++c) {
    EXPECT_EQ(outcome.tracks_of(c), 1) << "car " << c;
    EXPECT_GE(outcome.recall(c), least_recall) << "car " << c;
  }
}

}  // namespace vildar::scene
