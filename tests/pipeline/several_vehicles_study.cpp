#include <cmath>
#include <iostream>
#include <map>

#include "condition/condition.h"
#include "core/quantity.h"
#include "core/random.h"
#include "estimate/study.h"
#include "estimate/vehicle.h"
#include "optics/channel.h"

namespace vildar {
namespace {

constexpr double kUsualRate_hz = 1000.0;
constexpr double kGain_db = -42.4, kGainStd_db = 0.5;

struct Vehicle {
  double abeam_s = 0.0, speed_mps = 0.0, lateral_m = 0.0, height_m = 0.0, gain = 0.0;
  double pwm_hz = 0.0, duty = 1.0;  ///< of its lamps' pulses; 0: a steady light

  double light(double time_s) const {
    const double turns = pwm_hz * time_s;
    return turns - std::floor(turns) < duty ? 1.0 / duty : 0.0;
  }
};

Site site_with(std::size_t photodiodes, std::size_t lanes) {
  Site site;
  for (std::size_t i = 0; i < photodiodes; ++i) {
    PhotodiodeSite& diode = site.photodiodes.emplace_back();
    diode.id = "pd" + std::to_string(i);
    diode.position_m = {Uncertain{2.0 * static_cast<double>(i)}, Uncertain{0.0}, Uncertain{4.0}};
  }
  for (std::size_t i = 0; i < lanes; ++i)
    site.road.lanes.push_back({"lane" + std::to_string(i),
                               {-3.0 - 3.5 * static_cast<double>(i), 0.0},
                               3.5,
                               Direction::oncoming});
  site.lamps.height_m = Uncertain{0.66, 0.05};
  site.channel.emplace();
  site.channel->gain_db = Uncertain{kGain_db, kGainStd_db};
  site.channel->path_loss_exponent = Uncertain{2.0, 0.0};
  return site;
}

Vehicle drawn(const Site& site, std::size_t lane, double abeam_s, double speed_mps,
              Random& random) {
  return {abeam_s,
          speed_mps,
          site.road.lanes[lane].lateral_m.mean + random.normal(0.0, 3.5 / 12.0),
          random.normal(0.66, 0.05),
          ratio_from_db(random.normal(kGain_db, kGainStd_db)),
          0.0,
          1.0};
}

/// The second drives 15 to 60 m behind the first as that passes, at most a tenth faster.
std::vector<Vehicle> pair_of(const Site& site, Random& random) {
  const auto lane = [&] {
    return std::min(
        site.road.lanes.size() - 1,
        static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(site.road.lanes.size()))));
  };
  const Vehicle first = drawn(site, lane(), 8.0, random.uniform(8.0, 33.0), random);
  const double speed_mps = first.speed_mps * random.uniform(0.8, 1.1);
  const double behind_m = random.uniform(15.0, 60.0);
  return {first, drawn(site, lane(), 8.0 + behind_m / speed_mps, speed_mps, random)};
}

/// One in each lane, at one place within a tenth of a second; the outer one is up to a third
/// faster.
std::vector<Vehicle> abreast(const Site& site, Random& random) {
  const Vehicle inner = drawn(site, 0, 8.0, random.uniform(8.0, 27.0), random);
  return {inner, drawn(site, 1, 8.0 + random.uniform(0.0, 0.1),
                       inner.speed_mps * random.uniform(1.0, 1.33), random)};
}

std::vector<PowerTrace> traces_of(const std::vector<Vehicle>& vehicles, const Site& site,
                                  double rate_hz, Random& random) {
  // 40 dB at 60 m.
  const double noise_w = ratio_from_db(kGain_db) / 3600.0 / 100.0;
  PhotodiodeRecording recording;
  const auto samples = static_cast<std::size_t>((vehicles.back().abeam_s + 4.0) * rate_hz);
  for (std::size_t k = 0; k < samples; ++k)
    recording.time_s.push_back(static_cast<double>(k) / rate_hz);
  for (const PhotodiodeSite& diode : site.photodiodes) {
    recording.ids.push_back(diode.id);
    std::vector<float>& values = recording.values.emplace_back();
    for (const double time_s : recording.time_s) {
      double power_w = 2e-9 + random.normal(0.0, noise_w);
      for (const Vehicle& vehicle : vehicles) {
        const double ahead_m =
            vehicle.speed_mps * (vehicle.abeam_s - time_s) - diode.position_m[0].mean;
        if (ahead_m <= 0.0) continue;
        const double across_m =
            std::hypot(vehicle.lateral_m, diode.position_m[2].mean - vehicle.height_m);
        power_w += vehicle.gain * vehicle.light(time_s) / (ahead_m * ahead_m + across_m * across_m);
      }
      values.push_back(static_cast<float>(power_w));
    }
  }
  return condition(recording, site);
}

struct Tally {
  int vehicles = 0, passes = 0, measured = 0, covered = 0, far_off = 0, wrong_vehicle = 0;
  double worst = 0.0;
  std::map<std::string, int> withheld;
};

bool holds(const SpeedEstimate& speed, double truth_mps) {
  return speed.lo95_mps <= truth_mps && truth_mps <= speed.hi95_mps;
}

/// Alone, with lamps that pulse; instants are sampled, so that fast pulses alias.
std::vector<Vehicle> pulsed(const Site& site, double most_hz, Random& random) {
  Vehicle vehicle = drawn(site, 0, 8.0, random.uniform(8.0, 33.0), random);
  vehicle.pwm_hz = random.uniform(100.0, most_hz);
  vehicle.duty = random.uniform(0.2, 0.9);
  return {vehicle};
}

std::vector<Vehicle> slowly_pulsed(const Site& site, Random& random) {
  return pulsed(site, 250.0, random);
}

std::vector<Vehicle> fast_pulsed(const Site& site, Random& random) {
  return pulsed(site, 999.0, random);
}

using Draw = std::vector<Vehicle> (*)(const Site& site, Random& random);

Tally study(const Site& site, Draw draw, int trials, std::uint64_t seed,
            double rate_hz = kUsualRate_hz) {
  constexpr double kNear_s = 0.3;
  Tally tally;
  Random random(seed);
  for (int trial = 0; trial < trials; ++trial) {
    const std::vector<Vehicle> vehicles = draw(site, random);
    const std::vector<PowerTrace> traces = traces_of(vehicles, site, rate_hz, random);
    for (const PowerPass& pass : find_passes(traces.front())) {
      ++tally.passes;
      const VehicleResult result = estimate_pass(pass, 1, site, traces);
      if (result.withheld) {
        ++tally.withheld[std::string(name_of(*result.withheld))];
        continue;
      }
      ++tally.measured;
      for (std::size_t i = 0; i < vehicles.size(); ++i) {
        if (std::abs(vehicles[i].abeam_s - pass.peak_s) > kNear_s) continue;
        const double error_mps = result.speed.speed_mps - vehicles[i].speed_mps;
        tally.covered += holds(result.speed, vehicles[i].speed_mps);
        tally.far_off += std::abs(error_mps) > 4.0 * result.speed.std_mps;
        for (const Vehicle& other : vehicles)
          tally.wrong_vehicle +=
              !holds(result.speed, vehicles[i].speed_mps) && holds(result.speed, other.speed_mps);
        tally.worst = std::max(tally.worst, std::abs(error_mps) / vehicles[i].speed_mps);
      }
    }
    tally.vehicles += static_cast<int>(vehicles.size());
  }
  std::cout << tally.vehicles << " vehicles, " << tally.passes << " passes, " << tally.measured
            << " measured, " << tally.covered << " covered, " << tally.far_off
            << " off by 4 sigmas, " << tally.wrong_vehicle << " of the other, worst "
            << 100.0 * tally.worst << " %; withheld:";
  for (const auto& [reason, count] : tally.withheld) std::cout << ' ' << reason << ' ' << count;
  std::cout << '\n';
  return tally;
}

struct Case {
  const char* name;
  std::size_t photodiodes, lanes;
};

// Half the vehicles have another 15 to 60 m behind; no speed may be that of another, and intervals
// hold.
using SeveralVehiclesStudy = Study;

TEST_F(SeveralVehiclesStudy, NoSpeedIsThatOfTheOther) {
  constexpr int kTrials = 250;
  std::uint64_t seed = 1;
  for (const Case& one :
       {Case{"one photodiode, one lane", 1, 1}, Case{"one photodiode, two lanes", 1, 2},
        Case{"two photodiodes, one lane", 2, 1}, Case{"two photodiodes, two lanes", 2, 2}}) {
    std::cout << one.name << ": ";
    const Tally tally = study(site_with(one.photodiodes, one.lanes), pair_of, kTrials, seed++);
    EXPECT_GE(tally.passes, 0.98 * tally.vehicles) << one.name;
    EXPECT_GE(tally.covered, 0.92 * tally.measured) << one.name;
    EXPECT_EQ(tally.far_off, 0) << one.name;
    EXPECT_LE(tally.worst, one.photodiodes > 1 ? 0.03 : 0.5) << one.name;
  }
}

// Light alone does not part two that are abreast; most are seen to be no single one.
TEST_F(SeveralVehiclesStudy, TwoAbreastAreSeldomOne) {
  constexpr int kTrials = 250;
  const Tally tally = study(site_with(2, 2), abreast, kTrials, 30);
  EXPECT_LE(tally.measured, kTrials / 20);
  EXPECT_LE(tally.worst, 0.02);
}

// Where samples tell on from off the light is that of steady lamps; where they alias the speed must
// be withheld or its interval wide.
TEST_F(SeveralVehiclesStudy, LampsThatPulseGiveNoWrongSpeed) {
  constexpr int kTrials = 200;
  struct Sampling {
    const char* name;
    Draw draw;
    double rate_hz, least_measured;
  };
  std::uint64_t seed = 20;
  for (const Sampling& sampling : {Sampling{"100 to 999 Hz at 1 kHz", fast_pulsed, 1e3, 0.2},
                                   Sampling{"100 to 250 Hz at 1 kHz", slowly_pulsed, 1e3, 0.7},
                                   Sampling{"100 to 999 Hz at 10 kHz", fast_pulsed, 1e4, 0.95}})
    for (const std::size_t photodiodes : {1U, 2U}) {
      std::cout << photodiodes << " photodiodes, lamps that pulse, " << sampling.name << ": ";
      const Tally tally =
          study(site_with(photodiodes, 1), sampling.draw, kTrials, seed++, sampling.rate_hz);
      EXPECT_GE(tally.measured, sampling.least_measured * kTrials) << sampling.name;
      EXPECT_GE(tally.covered, 0.92 * tally.measured) << sampling.name;
      EXPECT_EQ(tally.far_off, 0) << sampling.name;
    }
}

}  // namespace
}  // namespace vildar
