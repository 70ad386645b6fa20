#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "optics/camera.h"
#include "properties/random_pass.h"

namespace vildar {
namespace {

using properties::agree;
using properties::between;
using properties::Pass;
using properties::random_pass;

// The same sums in another order: what is left is the solver's tolerance.
constexpr double kSolver = 1e-5;
constexpr double kNoise_px = 0.2;

/// The site as its mirror image in the plane y = 0.
Site mirrored(Site site) {
  CameraSite& camera = *site.camera;
  camera.yaw_rad.mean *= -1.0;
  camera.roll_rad.mean *= -1.0;
  camera.position_m[1].mean *= -1.0;
  camera.principal_px[0] = camera.width_px - 1 - camera.principal_px[0];
  camera.distortion_coefficients[3] *= -1.0;  // p2, the tangential one that is even in x
  for (LaneSite& lane : site.road.lanes) lane.lateral_m.mean *= -1.0;
  site.road.turn = site.road.turn == Turn::left ? Turn::right : Turn::left;
  return site;
}

VehicleTrack mirrored(VehicleTrack track, int width_px) {
  for (VehicleSighting& sighting : track.sightings) {
    for (auto* lamp : {&sighting.left, &sighting.right}) {
      if (!*lamp) continue;
      (*lamp)->centre_px.x() = width_px - 1 - (*lamp)->centre_px.x();
      const PixelBox box = (*lamp)->box;
      (*lamp)->box.u_min = width_px - 1 - box.u_max;
      (*lamp)->box.u_max = width_px - 1 - box.u_min;
    }
    if (sighting.left && sighting.right) std::swap(sighting.left, sighting.right);
  }
  return track;
}

RC_GTEST_PROP(CameraProperties, AMirroredSceneHasMirroredBearingsAndTheSameSpeed, ()) {
  const Pass pass = random_pass(kNoise_px, true);
  const VehicleEstimate here = estimate_vehicle(pass.track, pass.site, {});
  const VehicleEstimate there =
      estimate_vehicle(mirrored(pass.track, pass.site.camera->width_px), mirrored(pass.site), {});
  RC_ASSERT(here.result.withheld == there.result.withheld);
  RC_ASSERT(here.rows.size() == there.rows.size());
  for (std::size_t i = 0; i < here.rows.size(); ++i) {
    const auto& bearing = here.rows[i].bearing_rad;
    const auto& mirror = there.rows[i].bearing_rad;
    RC_ASSERT(bearing.has_value() == mirror.has_value());
    if (!bearing) continue;
    RC_ASSERT(agree(bearing->x(), -mirror->x(), kSolver));
    RC_ASSERT(agree(bearing->y(), mirror->y(), kSolver));
  }
  RC_PRE(!here.result.withheld);
  RC_ASSERT(agree(here.result.speed.speed_mps, there.result.speed.speed_mps, kSolver));
  RC_ASSERT(agree(here.result.speed.std_mps, there.result.speed.std_mps, kSolver));
  RC_ASSERT(agree(*here.result.lateral_m, -*there.result.lateral_m, kSolver));
  RC_ASSERT(agree(*here.result.range_ref_m, *there.result.range_ref_m, kSolver));
}

RC_GTEST_PROP(CameraProperties, TimeScaledByTwoHalvesTheSpeed, ()) {
  // Free of noise: the prior of the acceleration, which is not scaled, then has nothing to pull at.
  const Pass pass = random_pass(1e-7, true);
  Site slow_site = pass.site;
  slow_site.camera->rolling_shutter_s *= 2.0;
  VehicleTrack slow = pass.track;
  for (VehicleSighting& sighting : slow.sightings)
    sighting.time = CameraTime(2 * sighting.time.time_since_epoch());
  const VehicleResult fast = estimate_vehicle(pass.track, pass.site, {}).result;
  const VehicleResult half = estimate_vehicle(slow, slow_site, {}).result;
  RC_PRE(!fast.withheld);
  RC_ASSERT(!half.withheld);
  RC_ASSERT(agree(fast.speed.speed_mps, pass.vehicle.speed_mps, kSolver));
  RC_ASSERT(agree(half.speed.speed_mps, 0.5 * pass.vehicle.speed_mps, kSolver));
}

RC_GTEST_PROP(CameraProperties, MovingTheWholeSiteLeavesTheSpeedAlone, ()) {
  const Pass pass = random_pass(kNoise_px, false);
  const double along_m = between(-100.0, 100.0);
  const double aside_m = between(-20.0, 20.0);
  Site moved = pass.site;
  moved.camera->position_m[0].mean += along_m;
  moved.camera->position_m[1].mean += aside_m;
  for (LaneSite& lane : moved.road.lanes) lane.lateral_m.mean += aside_m;
  const VehicleResult here = estimate_vehicle(pass.track, pass.site, {}).result;
  const VehicleResult there = estimate_vehicle(pass.track, moved, {}).result;
  RC_ASSERT(here.withheld == there.withheld);
  RC_PRE(!here.withheld);
  RC_ASSERT(agree(here.speed.speed_mps, there.speed.speed_mps, kSolver));
  RC_ASSERT(agree(here.speed.std_mps, there.speed.std_mps, kSolver));
  RC_ASSERT(agree(*here.range_ref_m + along_m, *there.range_ref_m, kSolver));
  RC_ASSERT(agree(*here.lateral_m + aside_m, *there.lateral_m, kSolver));
}

}  // namespace
}  // namespace vildar
