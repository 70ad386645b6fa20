#include "estimate/unmix.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "simulated_power.h"

namespace vildar {
namespace {

using simulated::Diode;
using simulated::Vehicle;

constexpr Diode kDiode{
    .from_s = -2.0, .to_s = 6.0, .gain_w = 1.0, .ambient_w = 1e-3, .noise_w = 1e-6};
constexpr Vehicle kLeader{20.0, 0.0, 60.0, -4.0, 0.65, 1.2};
constexpr Vehicle kFollower{19.0, 0.0, 90.0, -4.0, 0.65, 1.2};

Site diode_site() {
  Site site = simulated::mast_site(4.0);
  site.photodiodes.resize(1);
  site.photodiodes[0].position_m = {Uncertain{0.0}, Uncertain{0.0}, Uncertain{4.0}};
  site.channel = ChannelSite{};
  site.channel->path_loss_exponent = Uncertain{2.0, 0.0};
  return site;
}

Trajectory way_of(const Vehicle& vehicle, const Site& site) {
  Random random(1);
  const double from_s = (vehicle.along_m - 60.0) / vehicle.speed_mps;
  const simulated::View view{.from_s = from_s, .to_s = from_s + 2.4, .sigma_px = 0.01};
  std::vector<std::string> warnings;
  return std::get<std::vector<Trajectory>>(
             fit_trajectories(simulated::track_of(vehicle, site, view, random),
                              Camera(*site.camera), site, warnings))
      .front();
}

PowerTrace sum_of(std::span<const Vehicle> vehicles, const Site& site) {
  Random random(2);
  PowerTrace sum = simulated::trace_of(vehicles[0], site, kDiode, random);
  Diode noiseless = kDiode;
  noiseless.noise_w = noiseless.ambient_w = 0.0;
  for (const Vehicle& vehicle : vehicles.subspan(1)) {
    const PowerTrace other = simulated::trace_of(vehicle, site, noiseless, random);
    for (std::size_t i = 0; i < sum.power_w.size(); ++i) sum.power_w[i] += other.power_w[i];
  }
  return sum;
}

TEST(OwnLight, LeavesTheLightOfOneVehicle) {
  const Site site = diode_site();
  const std::array<Vehicle, 2> vehicles{kLeader, kFollower};
  const std::array<Trajectory, 2> ways{way_of(kLeader, site), way_of(kFollower, site)};
  const std::array<const Trajectory*, 2> both{&ways[0], &ways[1]};
  const PowerTrace sum = sum_of(vehicles, site);
  const auto outcome = own_light(sum, site, both, 0, -0.5, 6.0);
  ASSERT_TRUE(std::holds_alternative<PowerTrace>(outcome));
  const PowerTrace& own = std::get<PowerTrace>(outcome);
  Random random(3);
  const PowerTrace alone = simulated::trace_of(kLeader, site, kDiode, random);
  ASSERT_GT(own.time_s.size(), 500U);
  for (std::size_t i = 0; i < own.time_s.size(); ++i) {
    const auto k = static_cast<std::size_t>(std::lround((own.time_s[i] + 2.0) * 1000.0));
    EXPECT_NEAR(own.power_w[i], alone.power_w[k], 4.0 * own.ambient_sigma_w + 8.0 * kDiode.noise_w)
        << own.time_s[i];
  }
}

TEST(OwnLight, TellsOfLightThatNoVehicleExplains) {
  const Site site = diode_site();
  const Vehicle neighbour{20.0, 0.0, 40.0, -7.5, 0.65, 1.2};
  const std::array<Vehicle, 3> vehicles{kLeader, kFollower, neighbour};
  const std::array<Trajectory, 2> ways{way_of(kLeader, site), way_of(kFollower, site)};
  const std::array<const Trajectory*, 2> both{&ways[0], &ways[1]};
  const auto outcome = own_light(sum_of(vehicles, site), site, both, 0, -0.5, 6.0);
  ASSERT_TRUE(std::holds_alternative<Miss>(outcome));
  EXPECT_EQ(std::get<Miss>(outcome), Miss::bad_fit);
}

// Their light falls with another exponent than the mean of what the site says, and off the axis.
TEST(OwnLight, LampsUnlikeALooseLawAreNoStrangers) {
  Site site = diode_site();
  site.channel->path_loss_exponent->std = 0.7;
  Diode diode = kDiode;
  diode.path_loss_exponent = 1.0;
  diode.cosine_exponent = 4.0;
  Random random(4);
  const PowerTrace trace = simulated::trace_of(kLeader, site, diode, random);
  const Trajectory way = way_of(kLeader, site);
  const std::array<const Trajectory*, 1> alone{&way};
  EXPECT_TRUE(std::holds_alternative<PowerTrace>(own_light(trace, site, alone, 0, -0.5, 4.0)));
}

TEST(OwnLight, SaysWhatIsMissing) {
  const Site site = diode_site();
  const Trajectory way = way_of(kLeader, site);
  const std::array<const Trajectory*, 1> ways{&way};
  const std::array<Vehicle, 1> vehicles{kLeader};
  const PowerTrace trace = sum_of(vehicles, site);
  Site without_law = site;
  without_law.channel.reset();
  EXPECT_EQ(std::get<Miss>(own_light(trace, without_law, ways, 0, -0.5, 6.0)), Miss::no_scale);
  EXPECT_EQ(std::get<Miss>(own_light(trace, site, ways, 0, 100.0, 101.0)), Miss::too_few_samples);
  EXPECT_EQ(std::get<Miss>(own_light(trace, site, ways, 0, 4.0, 6.0)), Miss::below_noise);
}

}  // namespace
}  // namespace vildar
