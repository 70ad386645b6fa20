#include <array>
#include <cmath>
#include <cstdio>
#include <map>

#include "core/quantity.h"
#include "estimate/simulated_pass.h"
#include "estimate/study.h"
#include "estimate/vehicle.h"
#include "optics/channel.h"
#include "pipelines/vehicle_power.h"

namespace vildar {
namespace {

using simulated::Vehicle;

constexpr double kGain_db = -42.4, kGainStd_db = 0.5;
constexpr double kInView_m = 60.0, kOutOfView_m = 10.0;

Site two_lanes() {
  Site site = simulated::mast_site(4.0);
  site.road.lanes.push_back({"far", {-7.5, 0.3}, 3.5, Direction::oncoming});
  PhotodiodeSite& diode = site.photodiodes.emplace_back();
  diode.id = "pd0";
  diode.position_m = {Uncertain{0.0}, Uncertain{0.0}, Uncertain{4.0}};
  diode.time_offset_s.std = 0.002;
  site.channel.emplace();
  site.channel->gain_db = Uncertain{kGain_db, kGainStd_db};
  site.channel->path_loss_exponent = Uncertain{2.0, 0.0};
  return site;
}

struct Car {
  Vehicle vehicle;
  double gain = 1.0;
  VehicleTrack track;

  // When it is so far along its path.
  double time_at_s(double along_m) const {
    double low_s = -20.0, high_s = 40.0;
    for (int i = 0; i < 60; ++i) {
      const double middle_s = 0.5 * (low_s + high_s);
      (vehicle.along_at_m(middle_s) > along_m ? low_s : high_s) = middle_s;
    }
    return low_s;
  }
  ClipInterval in_view() const { return {time_at_s(kInView_m), time_at_s(kOutOfView_m)}; }
};

Car car(double speed_mps, double along_m, double lateral_m, const Site& site, Random& random) {
  Car made;
  made.vehicle.speed_mps = speed_mps;
  made.vehicle.along_m = along_m;
  made.vehicle.lateral_m = random.normal(lateral_m, 0.3);
  made.vehicle.height_m = random.normal(0.65, 0.1);
  made.vehicle.separation_m = random.normal(1.2, 0.15);
  made.gain = ratio_from_db(random.normal(kGain_db, kGainStd_db));
  const ClipInterval seen = made.in_view();
  const simulated::View view{.from_s = seen.from_s, .to_s = seen.to_s};
  made.track = simulated::track_of(made.vehicle, site, view, random);
  return made;
}

// One car, a second 15 to 60 m behind, and a neighbour in the other lane.
std::vector<Car> cars_of(const Site& site, Random& random) {
  const double speed_mps = random.uniform(8.0, 33.0);
  const auto other_mps = [&] { return speed_mps * random.uniform(0.8, 1.1); };
  const double second_m = kInView_m + random.uniform(15.0, 60.0);
  const double beside_m = kInView_m + random.uniform(-30.0, 90.0);
  std::vector<Car> cars;
  cars.push_back(car(speed_mps, kInView_m, -4.0, site, random));
  cars.push_back(car(other_mps(), second_m, -4.0, site, random));
  cars.push_back(car(other_mps(), beside_m, -7.5, site, random));
  for (std::size_t i = 0; i < cars.size(); ++i) cars[i].track.id = static_cast<int>(i) + 1;
  return cars;
}

double light_of(const Car& car, const RoadSite& road, const Eigen::Vector3d& receiver_m,
                double t_s) {
  const Eigen::Vector3d apart_m = simulated::lamps_at(car.vehicle, road, t_s).middle_m - receiver_m;
  return apart_m.x() > 0.0 ? car.gain / apart_m.squaredNorm() : 0.0;
}

PowerTrace trace_of(const std::vector<Car>& cars, const Site& site, Random& random) {
  const auto& place = site.photodiodes.front().position_m;
  const Eigen::Vector3d receiver_m(place[0].mean, place[1].mean, place[2].mean);
  PowerTrace trace;
  trace.photodiode_id = site.photodiodes.front().id;
  trace.sample_period_s = 1e-3;
  const double first_w = light_of(cars.front(), site.road, receiver_m, 0.0);
  trace.noise_sigma_w = first_w * 0.01;  // 40 dB
  trace.ambient_w = 0.5 * first_w;
  trace.ambient_sigma_w = trace.noise_sigma_w / 20.0;
  double end_s = 0.0;
  for (const Car& one : cars) end_s = std::max(end_s, one.time_at_s(-5.0));
  for (double t_s = -2.0; t_s < end_s; t_s += 1e-3) {
    double power_w = trace.ambient_w + trace.noise_sigma_w * random.normal();
    for (const Car& one : cars) power_w += light_of(one, site.road, receiver_m, t_s);
    trace.time_s.push_back(t_s);
    trace.power_w.push_back(static_cast<float>(power_w));
  }
  return trace;
}

struct Row {
  int asked = 0, measured = 0, covered = 0, far_off = 0, of_another = 0;
  double square = 0.0;

  void add(const SpeedEstimate* speed, const std::vector<Car>& cars, std::size_t own) {
    ++asked;
    if (!speed) return;
    ++measured;
    const auto truth_mps = [&](const Car& one) { return one.vehicle.speed_at_mps(speed->time_s); };
    const auto holds = [&](double mps) { return speed->lo95_mps <= mps && mps <= speed->hi95_mps; };
    const double error_mps = speed->speed_mps - truth_mps(cars[own]);
    square += std::pow(error_mps / truth_mps(cars[own]), 2);
    far_off += std::abs(error_mps) > 4.0 * speed->std_mps;
    if (holds(truth_mps(cars[own]))) {
      ++covered;
      return;
    }
    for (const Car& other : cars)
      if (&other != &cars[own] && holds(truth_mps(other))) {
        ++of_another;
        break;
      }
  }
  void print(const std::string& what) const {
    std::printf("  %-24s %3d of %3d, inside %.3f, 4 sigmas off %2d, of another %2d, RMSE %.2f %%\n",
                what.c_str(), measured, asked, static_cast<double>(covered) / std::max(1, measured),
                far_off, of_another, 100.0 * std::sqrt(square / std::max(1, measured)));
  }
};

using Table = std::map<std::string, Row>;

void tally(const VehicleResult& result, const std::vector<Car>& cars, std::size_t own,
           Table& table) {
  table["speeds.csv"].add(result.withheld ? nullptr : &result.speed, cars, own);
  for (const MethodResult& row : result.methods)
    if (row.method != Method::power_slope_camera && row.method != Method::geometry_camera)
      table[std::string(name_of(row.method))].add(std::get_if<SpeedEstimate>(&row.speed), cars,
                                                  own);
}

// The camera sees the first `seen` of the three.
Table study(std::size_t seen, std::uint64_t seed) {
  constexpr int kScenes = 170;
  const Site site = two_lanes();
  Random random(seed);
  Table table;
  int unexplained = 0;
  for (int scene = 0; scene < kScenes; ++scene) {
    const std::vector<Car> cars = cars_of(site, random);
    const std::vector<PowerTrace> traces{trace_of(cars, site, random)};
    std::vector<LitVehicle> lit;
    for (std::size_t i = 0; i < seen; ++i) lit.push_back(lit_vehicle(cars[i].track, site));
    for (std::size_t own = 0; own < seen; ++own) {
      const OfferedPower offered = offer_power(lit, own, site, traces);
      unexplained += offered.unexplained;
      tally(estimate_vehicle(cars[own].track, site, offered.power).result, cars, own, table);
    }
  }
  for (const auto& [what, row] : table) row.print(what);
  std::printf("  light that no vehicle explains: %d times\n", unexplained);
  std::fflush(stdout);
  return table;
}

constexpr std::array<const char*, 3> kOfLight{"power_slope_photodiode", "ml_photodiode",
                                              "speeds.csv"};

using SharedPhotodiodeStudy = Study;

TEST_F(SharedPhotodiodeStudy, ThreeVehiclesThatTheCameraSees) {
  Table table = study(3, 1);
  for (const char* what : kOfLight) {
    const Row& row = table[what];
    EXPECT_GE(row.measured, row.asked / 3) << what;
    EXPECT_GE(row.covered, 0.93 * row.measured) << what;
    EXPECT_EQ(row.far_off, 0) << what;
  }
}

TEST_F(SharedPhotodiodeStudy, ANeighbourThatTheCameraDoesNotSee) {
  Table table = study(2, 3);
  const Row& row = table["speeds.csv"];
  EXPECT_GE(row.covered, 0.92 * row.measured);
  EXPECT_EQ(row.far_off, 0);
}

}  // namespace
}  // namespace vildar
