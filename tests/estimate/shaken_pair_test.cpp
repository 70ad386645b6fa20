#include <algorithm>
#include <cmath>

#include "estimate/bearing_fit.h"
#include "geometry_pass.h"
#include "support/trials.h"

namespace vildar {
namespace {

using simulated::mast_site;
using simulated::track_of;
using simulated::Vehicle;
using simulated::View;

constexpr double kDrives_mps = 15.0;

// Moves both lamps of a frame together, as a camera that shakes slower than its frames come.
void shake(VehicleTrack& track, const Eigen::Vector2d& by_px, Random& random) {
  constexpr double kFromFrameToFrame = 0.92;
  const auto draw = [&] { return Eigen::Vector2d(random.normal(), random.normal()); };
  Eigen::Vector2d at = draw();
  for (VehicleSighting& sighting : track.sightings) {
    at = kFromFrameToFrame * at + std::sqrt(1.0 - kFromFrameToFrame * kFromFrameToFrame) * draw();
    for (auto* lamp : {&sighting.left, &sighting.right})
      if (*lamp) (*lamp)->centre_px += by_px.cwiseProduct(at);
  }
}

// An error that both lamps of a frame share costs by one factor, one by which they part by another.
TEST(ShakenPair, CommonAndPartingErrorsCostByTheirFactors) {
  constexpr double kTogether = 10.0, kApart = 2.0, kSmall = 0.5;  // sigmas, none is softened
  const Site site = mast_site(4.0);
  Random random(1);
  const auto outcome =
      fit_bearings(track_of(Vehicle{}, site, View{}, random), Camera(*site.camera), site);
  ASSERT_TRUE(std::holds_alternative<BearingFit>(outcome));
  const Trajectory& seen = std::get<BearingFit>(outcome).trajectory;
  GeometryProblem problem = seen.problem;
  const PathVector& path = seen.fit.parameters;
  const Eigen::Matrix2Xd off = bearing_residuals(problem, path);
  for (std::size_t i = 0; i < problem.lamps.size(); ++i)
    problem.lamps[i].normalized +=
        off.col(static_cast<Eigen::Index>(i)).cwiseProduct(problem.lamps[i].sigma);
  problem.sigma_factor = {kTogether, kTogether};
  problem.apart_factor = kApart;
  const std::size_t first = 10;
  ASSERT_EQ(problem.lamps[first].sighting, problem.lamps[first + 1].sighting);
  const auto cost_of = [&](double one, double other) {
    GeometryProblem moved = problem;
    moved.lamps[first].normalized.x() += one * moved.lamps[first].sigma.x();
    moved.lamps[first + 1].normalized.x() += other * moved.lamps[first + 1].sigma.x();
    const auto cost = geometry_cost(moved, path);
    const auto residuals = geometry_residuals(moved, path, free_parameters(moved), Slopes::of_path);
    EXPECT_TRUE(cost && residuals);
    EXPECT_NEAR(*cost, residuals->cost, 1e-9 * *cost);
    return *cost;
  };
  const double exact = cost_of(0.0, 0.0);
  EXPECT_NEAR(cost_of(kSmall, kSmall) - exact, std::pow(kSmall / kTogether, 2), 1e-9);
  EXPECT_NEAR(cost_of(kSmall, -kSmall) - exact, std::pow(kSmall / kApart, 2), 1e-9);
}

// How far apart its lamps are seen tells what one ahead does, whatever the camera does: the frames
// shake by a quarter of a degree, the lamps of a frame stand to a tenth of a pixel.
TEST(ShakenPair, OneAheadWhoBrakesIsFollowedByHowFarApartItsLampsAreSeen) {
  constexpr int kCars = trials(60);
  int measured = 0, inside = 0;
  double squares = 0.0, shape_mps = 0.0;
  for (int i = 0; i < kCars; ++i) {
    Random random(static_cast<std::uint64_t>(20261128 + i));
    Site site = mast_site(1.4);
    site.camera->pitch_rad = {0.0, 0.003};
    site.camera->yaw_rad = {0.0, 0.003};
    site.road.lanes = {{"own", {0.0, 0.3}, 3.5, Direction::receding}};
    site.ego = EgoSite{{kDrives_mps, 0.0}, {}, {}};
    Vehicle ahead;
    ahead.speed_mps = -kDrives_mps + random.uniform(-1.0, 1.0);
    ahead.along_m = random.uniform(20.0, 38.0);
    ahead.lateral_m = 0.3 * random.normal();
    ahead.height_m = 0.68 + 0.1 * random.normal();
    ahead.separation_m = 1.25 + 0.1 * random.normal();
    const double from_s = random.uniform(1.5, 2.5), to_s = from_s + random.uniform(0.8, 1.5);
    const double braking_mps2 = random.uniform(1.5, 3.5);
    ahead.changes = {{from_s, braking_mps2}, {to_s, -braking_mps2}};
    View view;
    view.sigma_px = 0.1;
    view.to_s = 5.0;
    view.ego_mps = kDrives_mps;
    VehicleTrack track = track_of(ahead, site, view, random);
    track.kind = LampKind::taillamp;
    track.direction = Direction::receding;
    shake(track, {1.5, 5.0}, random);
    const VehicleResult result = estimate_vehicle(track, site, {}).result;
    if (result.withheld) continue;
    const double speed_mps = -ahead.speed_at_mps(result.speed.time_s);
    const double sigmas = (result.speed.speed_mps - speed_mps) / result.speed.std_mps;
    ++measured;
    inside += result.speed.lo95_mps <= speed_mps && speed_mps <= result.speed.hi95_mps;
    squares += sigmas * sigmas;
    shape_mps += result.budget->shape * result.speed.speed_mps;
    EXPECT_LT(std::abs(sigmas), 4.0) << i << ": " << result.speed.speed_mps << " +- "
                                     << result.speed.std_mps << " for " << speed_mps;
  }
  EXPECT_GE(measured, 0.95 * kCars);
  EXPECT_GE(inside, 0.88 * measured);
  EXPECT_LT(std::sqrt(squares / measured), 1.25);
  EXPECT_LT(shape_mps / measured, 0.16);
}

}  // namespace
}  // namespace vildar
