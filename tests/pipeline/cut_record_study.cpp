// One photodiode's records that begin with the vehicle in view and end before it is past or as it
// passes, as those of the paper do: no dark moment tells the ambient.
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <string>

#include "condition/condition.h"
#include "core/quantity.h"
#include "core/random.h"
#include "estimate/study.h"
#include "estimate/vehicle.h"
#include "optics/channel.h"

namespace vildar {
namespace {

constexpr int kTrials = 200;
constexpr double kRate_hz = 1000.0;
constexpr double kAmbientShare = 0.5;  // of the first light
constexpr double kSlowest_mps = 3.0;   // at which a record of a braking vehicle ends
// Three binomial sigmas of a coverage of 93 %.
constexpr double kLeastCoverage = 0.93 - 0.054;
constexpr double kLeastMeasured = 0.85;

struct Record {
  const char* name;
  double from_m, to_m;        // along the road
  double lateral_m, below_m;  // of the photodiode, lamp height
  double gain_db, exponent;
  double half_power_angle_deg;  // 0: no cosine
  double signal_db;             // of the first light over the noise, 20 log10
  double gain_std_nat, lateral_std_m, height_std_m;
  double slowest_mps, fastest_mps, acceleration_std_mps2;
};

constexpr Record kMast{"60 to 10 m, gain to 0.5 nat",
                       60.0,
                       10.0,
                       4.0,
                       3.35,
                       -42.0,
                       2.0,
                       0.0,
                       40.0,
                       0.5,
                       0.3,
                       0.1,
                       8.0,
                       35.0,
                       0.5};

Record with(Record record, const char* name, const std::function<void(Record&)>& change) {
  record.name = name;
  change(record);
  return record;
}

// The paper's: 15 m to abreast, d = 0.5 m, its two channels.
constexpr Record kPaper{"paper, 15 m to abreast, 30 dB",
                        15.0,
                        0.0,
                        0.5,
                        0.0,
                        -49.32,
                        1.21,
                        0.0,
                        30.0,
                        0.0,
                        0.0,
                        0.0,
                        5.0,
                        40.0,
                        0.0};

Site site_of(const Record& record) {
  Site site;
  PhotodiodeSite& diode = site.photodiodes.emplace_back();
  diode.id = "pd0";
  diode.position_m = {Uncertain{}, Uncertain{}, Uncertain{record.below_m + 0.65}};
  site.road.lanes.push_back(
      {"near", {-record.lateral_m, record.lateral_std_m}, 3.5, Direction::oncoming});
  site.lamps.height_m = Uncertain{0.65, record.height_std_m};
  site.channel.emplace();
  site.channel->gain_db = Uncertain{record.gain_db, record.gain_std_nat * 10.0 / std::log(10.0)};
  site.channel->path_loss_exponent = Uncertain{record.exponent, 0.0};
  if (record.half_power_angle_deg > 0.0)
    site.channel->half_power_angle_rad = radians_from_degrees(record.half_power_angle_deg);
  return site;
}

struct Tally {
  int measured = 0, covered = 0, far_off = 0;
  double error2 = 0.0, sigma2 = 0.0;

  void add(const SpeedEstimate& speed, double truth_mps) {
    ++measured;
    covered += speed.lo95_mps <= truth_mps && truth_mps <= speed.hi95_mps;
    far_off +=
        std::abs(std::log(speed.speed_mps / truth_mps)) > 4.0 * speed.std_mps / speed.speed_mps;
    error2 += std::pow(speed.speed_mps / truth_mps - 1.0, 2);
    sigma2 += std::pow(speed.std_mps / speed.speed_mps, 2);
  }
};

std::map<std::string, Tally> measured(const Record& record) {
  const Site site = site_of(record);
  std::map<std::string, Tally> tallies;
  Random random(20261125);
  for (int trial = 0; trial < kTrials; ++trial) {
    const double speed_mps = random.uniform(record.slowest_mps, record.fastest_mps);
    const double acceleration_mps2 = random.normal(0.0, record.acceleration_std_mps2);
    const double across_m = std::hypot(record.lateral_m + random.normal(0.0, record.lateral_std_m),
                                       record.below_m - random.normal(0.0, record.height_std_m));
    PowerLaw law{ratio_from_db(record.gain_db) * std::exp(random.normal(0.0, record.gain_std_nat)),
                 record.exponent, 0.0};
    if (site.channel->half_power_angle_rad)
      law.cosine_exponent = lambertian_order(Radians(*site.channel->half_power_angle_rad)) + 1.0;
    const double first_w = law.power_w(record.from_m, across_m);
    const double noise_w = first_w * std::pow(10.0, -record.signal_db / 20.0);
    PhotodiodeRecording recording;
    recording.ids = {"pd0"};
    recording.values.resize(1);
    for (int k = 0;; ++k) {
      const double time_s = k / kRate_hz;
      const double ahead_m =
          record.from_m - time_s * (speed_mps + 0.5 * acceleration_mps2 * time_s);
      if (!(ahead_m > record.to_m) || speed_mps + acceleration_mps2 * time_s < kSlowest_mps) break;
      recording.time_s.push_back(time_s);
      recording.values[0].push_back(static_cast<float>(
          law.power_w(ahead_m, across_m) + kAmbientShare * first_w + random.normal(0.0, noise_w)));
    }
    const std::vector<PowerTrace> traces = condition(recording, site);
    const std::vector<PowerPass> passes = find_passes(traces.front());
    EXPECT_EQ(passes.size(), 1U) << record.name << ' ' << trial;
    if (passes.empty()) continue;
    const VehicleResult result = estimate_pass(passes.back(), 1, site, traces);
    const auto truth_mps = [&](const SpeedEstimate& speed) {
      return speed_mps + acceleration_mps2 * speed.time_s;
    };
    for (const MethodResult& row : result.methods)
      if (const auto* speed = std::get_if<SpeedEstimate>(&row.speed))
        tallies[std::string(name_of(row.method))].add(*speed, truth_mps(*speed));
    if (!result.withheld) tallies["reported"].add(result.speed, truth_mps(result.speed));
  }
  return tallies;
}

using CutRecordStudy = Study;

TEST_F(CutRecordStudy, SpeedsHoldWithoutADarkMoment) {
  const Record records[]{
      kMast,
      with(kMast, "60 to 10 m, gain to 0.1 nat",
           [](Record& r) { r.gain_std_nat = 0.1, r.lateral_std_m = 0.1, r.height_std_m = 0.05; }),
      with(kMast, "the same, 20 dB",
           [](Record& r) {
             r.gain_std_nat = 0.1, r.lateral_std_m = 0.1, r.height_std_m = 0.05, r.signal_db = 20.0;
           }),
      with(kMast, "the same, 10 dB",
           [](Record& r) {
             r.gain_std_nat = 0.1, r.lateral_std_m = 0.1, r.height_std_m = 0.05, r.signal_db = 10.0;
           }),
      with(kPaper, "paper, 20 dB", [](Record& r) { r.signal_db = 20.0; }),
      kPaper,
      with(
          kPaper, "paper, Lambertian, 30 dB",
          [](Record& r) { r.gain_db = -41.39, r.exponent = 1.673, r.half_power_angle_deg = 40.0; }),
      with(kPaper, "paper, 15 to 6 m, 30 dB", [](Record& r) { r.to_m = 6.0; }),
  };
  for (const Record& record : records) {
    std::map<std::string, Tally> tallies = measured(record);
    for (const char* name : {"power_slope_photodiode", "ml_photodiode", "reported"}) {
      const Tally& tally = tallies[name];
      std::printf(
          "%s, %s: n %d of %d, rmse %.1f %%, sigma %.1f %%, inside %.1f %%, off by four %d\n",
          record.name, name, tally.measured, kTrials,
          100.0 * std::sqrt(tally.error2 / tally.measured),
          100.0 * std::sqrt(tally.sigma2 / tally.measured), 100.0 * tally.covered / tally.measured,
          tally.far_off);
      EXPECT_GE(tally.covered, kLeastCoverage * tally.measured) << record.name << ' ' << name;
      EXPECT_EQ(tally.far_off, 0) << record.name << ' ' << name;
      EXPECT_GE(tally.measured, kLeastMeasured * kTrials) << record.name << ' ' << name;
    }
  }
}

}  // namespace
}  // namespace vildar
