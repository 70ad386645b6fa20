#include "track/lamp.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "optics/camera.h"
#include "scene.h"

namespace vildar {
namespace {

// The own car drives round a circle of 150 m to the right at 18 m/s, an oncoming one round it on
// the other lane at 14 m/s; places from the circles alone.
TEST(Lamp, InABendTheOwnTurningIsNotTakenForNearing) {
  constexpr double kRadius_m = 150.0, kOwn_mps = 18.0, kOther_mps = 14.0, kDt_s = 1.0 / 30.0;
  constexpr double kOtherRadius_m = kRadius_m + 3.5;
  Site site = scene::site_of(1.3, 0.0, 1000.0, 1280, 720);
  site.road.kind = RoadKind::curved;
  site.road.turn = Turn::right;
  site.road.radius_m = Uncertain{kRadius_m, 5.0};
  site.ego = EgoSite{Uncertain{0.0, 0.1}, "ego.csv", {{0.0, kOwn_mps, -kOwn_mps / kRadius_m}}};
  const RoadView view(site);
  const Camera camera(*site.camera);
  // Of the other car, ahead by an angle round the centre of the bend.
  const auto angle_at = [&](double time_s) {
    return 60.0 / kRadius_m - time_s * (kOwn_mps / kRadius_m + kOther_mps / kOtherRadius_m);
  };
  const auto depth_at = [&](double time_s) { return kOtherRadius_m * std::sin(angle_at(time_s)); };
  std::optional<Lamp> lamp;
  for (int frame = 0; frame < 40; ++frame) {
    const double time_s = frame * kDt_s;
    const Eigen::Vector3d at_m(depth_at(time_s),
                               kOtherRadius_m * std::cos(angle_at(time_s)) - kRadius_m, 0.68);
    Blob blob;
    blob.centre_px = *camera.project(at_m);
    blob.flux = 100.0;
    blob.kind = LampKind::headlamp;
    const Spot spot{&blob, *view.spot_from_pixel(blob.centre_px), 0.5, blob.centre_px,
                    blob.centre_sigma_px};
    const auto time = time_from_seconds<CameraTime>(time_s);
    if (!lamp) {
      lamp.emplace(spot, view.place(spot.at_px), frame, time, view);
      continue;
    }
    lamp->predict(kDt_s, view);
    if (frame > 20) {
      EXPECT_LT((lamp->at_px() - spot.at_px).norm(), 0.5) << frame;
      const double rate_per_s = std::log(depth_at(time_s) / depth_at(time_s - kDt_s)) / kDt_s;
      EXPECT_NEAR(lamp->depth_rate_per_s(), rate_per_s, 0.25 * std::abs(rate_per_s)) << frame;
    }
    lamp->update(spot, frame, time);
  }
}

}  // namespace
}  // namespace vildar
