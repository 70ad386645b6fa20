#include <gtest/gtest.h>

#include "estimate/vehicle.h"
#include "simulated_power.h"

namespace vildar {
namespace {

using simulated::Diode;
using simulated::mast_site;
using simulated::trace_of;
using simulated::track_of;
using simulated::View;

constexpr double kPassing_mps = 16.0;

Site site_with_photodiode_at(double x_m, double y_m) {
  Site site = mast_site(4.0);
  site.photodiodes.resize(1);
  site.photodiodes[0].id = "pd0";
  site.photodiodes[0].position_m = {Uncertain{x_m, 0.0}, Uncertain{y_m, 0.0}, Uncertain{3.5, 0.0}};
  site.photodiodes[0].half_field_of_view_rad = 1.1;
  site.channel = ChannelSite{};
  site.channel->gain_db = Uncertain{-42.4, 1.0};
  site.channel->path_loss_exponent = Uncertain{2.0, 0.02};
  return site;
}

// Where the photodiode stands is a length that the site knows. Read by the law, light told speeds
// 30 sigmas off with it.
TEST(DisplacedPhotodiode, TellsTheCameraNoLengths) {
  constexpr int kTrials = 6;
  const simulated::Vehicle vehicle{.speed_mps = kPassing_mps, .along_m = 60.0};
  const View view{.to_s = 3.0, .sigma_px = 0.1};
  Random random(4);
  int fused_by_power = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Site site =
        trial % 2 == 0 ? site_with_photodiode_at(0.0, -9.0) : site_with_photodiode_at(-10.0, 0.0);
    Diode diode;
    diode.to_s = 4.0;
    diode.gain_w = std::pow(10.0, -4.24);
    diode.noise_w = 1e-10;
    for (std::size_t k = 0; k < diode.waves.size(); ++k)
      diode.waves[k] = random.normal(0.0, 0.3 / static_cast<double>(k + 1));
    const PowerTrace trace = trace_of(vehicle, site, diode, random);
    const VehicleTrack track = track_of(vehicle, site, view, random);
    const VehiclePower power{&trace, false};
    const VehicleResult camera = estimate_vehicle(track, site, {}).result;
    const VehicleResult fused = estimate_vehicle(track, site, {&power, 1}).result;
    ASSERT_FALSE(camera.withheld || fused.withheld);
    fused_by_power += fused.method == Method::fused;
    EXPECT_LE(std::abs(fused.speed.speed_mps - kPassing_mps), 3.0 * fused.speed.std_mps);
    EXPECT_NEAR(fused.speed.std_mps / camera.speed.std_mps, 1.0, 0.1);
    EXPECT_NEAR(fused.speed.speed_mps, camera.speed.speed_mps, camera.speed.std_mps);
  }
  EXPECT_GE(fused_by_power, kTrials - 1);
}

}  // namespace
}  // namespace vildar
