#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "capture/photodiode_csv.h"
#include "condition/condition.h"
#include "core/text.h"
#include "evaluate/csv_reader.h"
#include "properties/random_pass.h"
#include "support/temporary_folder.h"

namespace vildar {
namespace {

using properties::agree;
using properties::between;

/// A roadside with photodiodes side by side, and the paper's power law.
Site roadside(int photodiodes) {
  Site site;
  for (int i = 0; i < photodiodes; ++i) {
    PhotodiodeSite photodiode;
    photodiode.id = "pd" + std::to_string(i);
    photodiode.position_m[2].mean = 5.0;
    site.photodiodes.push_back(photodiode);
  }
  site.road.lanes = {{"near", {-3.4, 0.0}, 3.5, Direction::oncoming}};
  site.lamps.height_m = Uncertain{0.68, 0.0};
  site.channel = ChannelSite{};
  site.channel->gain_db = Uncertain{-50.0, 0.0};
  site.channel->path_loss_exponent = Uncertain{2.0, 0.0};
  return site;
}

struct Trace {
  std::vector<double> time_s, power_w;
};

/// One vehicle that comes and, at its passing, is gone.
Trace random_trace() {
  const double speed_mps = between(10.0, 30.0);
  const double passing_s = between(4.0, 6.0);
  Random random(static_cast<std::uint64_t>(*rc::gen::inRange(1, 1'000'000)));
  Trace trace;
  for (int k = 0; k < 1600; ++k) {
    const double time_s = 0.005 * k;
    const double range_m = speed_mps * (passing_s - time_s);
    const double distance_m = std::sqrt(range_m * range_m + 3.4 * 3.4 + 4.32 * 4.32);
    const double light_w = range_m > 0.0 ? 1e-5 * std::pow(distance_m, -2.0) : 0.0;
    trace.time_s.push_back(time_s);
    trace.power_w.push_back(light_w + random.normal(0.0, 1e-11));
  }
  return trace;
}

using Column = std::pair<std::string, std::vector<std::string>>;

Column column(const std::string& name, const std::vector<double>& values) {
  Column made{name, {}};
  for (const double value : values) made.second.push_back(number_text(value));
  return made;
}

std::string csv(const std::vector<Column>& columns) {
  std::string text;
  for (std::size_t row = 0; row <= columns.front().second.size(); ++row)
    for (std::size_t i = 0; i < columns.size(); ++i)
      text += (row == 0 ? columns[i].first : columns[i].second[row - 1]) +
              (i + 1 < columns.size() ? "," : "\n");
  return text;
}

std::vector<PowerTrace> traces_of(const std::string& text, const Site& site) {
  const TemporaryFolder folder;
  return condition(read_photodiode_csv(folder.write("trace.csv", text)), site);
}

/// Speed of the one pass of these traces.
VehicleResult speed_of(const std::vector<PowerTrace>& traces, const Site& site) {
  const std::vector<PowerPass> passes = find_passes(traces.front());
  RC_ASSERT(passes.size() == 1U);
  return estimate_pass(passes.front(), 1, site, traces);
}

std::vector<Column> shuffled(std::vector<Column> columns) {
  for (std::size_t i = columns.size(); i > 1; --i)
    std::swap(columns[i - 1],
              columns[static_cast<std::size_t>(*rc::gen::inRange(0, static_cast<int>(i)))]);
  return columns;
}

RC_GTEST_PROP(TraceProperties, TimeScaledByTwoHalvesTheSpeed, ()) {
  const Site site = roadside(1);
  Trace trace = random_trace();
  const VehicleResult fast = speed_of(
      traces_of(csv({column("t_s", trace.time_s), column("power_w", trace.power_w)}), site), site);
  for (double& time_s : trace.time_s) time_s *= 2.0;
  const VehicleResult half = speed_of(
      traces_of(csv({column("t_s", trace.time_s), column("power_w", trace.power_w)}), site), site);
  RC_ASSERT(!fast.withheld);
  RC_ASSERT(!half.withheld);
  // The blocks of the pass finder have a fixed length, so its ends move by one of them.
  constexpr double kEnds = 0.01;
  RC_ASSERT(agree(half.speed.speed_mps, 0.5 * fast.speed.speed_mps, kEnds));
}

RC_GTEST_PROP(TraceProperties, MovingTheWholeSiteLeavesTheSpeedAlone, ()) {
  const Site site = roadside(1);
  Site moved = site;
  const double aside_m = between(-20.0, 20.0), along_m = between(-100.0, 100.0);
  moved.photodiodes[0].position_m[0].mean += along_m;
  moved.photodiodes[0].position_m[1].mean += aside_m;
  moved.road.lanes[0].lateral_m.mean += aside_m;
  const Trace trace = random_trace();
  const std::string text = csv({column("t_s", trace.time_s), column("power_w", trace.power_w)});
  const VehicleResult here = speed_of(traces_of(text, site), site);
  const VehicleResult there = speed_of(traces_of(text, moved), moved);
  RC_ASSERT(!here.withheld);
  RC_ASSERT(!there.withheld);
  RC_ASSERT(agree(here.speed.speed_mps, there.speed.speed_mps, 1e-9));
  RC_ASSERT(agree(here.speed.std_mps, there.speed.std_mps, 1e-9));
}

RC_GTEST_PROP(TraceProperties, ShuffledColumnsChangeNothing, ()) {
  const Trace one = random_trace(), two = random_trace();
  std::vector<Column> columns{column("t_s", one.time_s), column("pd0_power_w", one.power_w),
                              column("pd1_power_w", two.power_w),
                              column("note", std::vector<double>(one.time_s.size(), 7.0))};
  const Site site = roadside(2);
  const auto expected = traces_of(csv(columns), site);
  const auto found = traces_of(csv(shuffled(columns)), site);
  RC_ASSERT(found.size() == expected.size());
  for (const PowerTrace& trace : found) {
    const PowerTrace& same = expected[static_cast<std::size_t>(trace.photodiode)];
    RC_ASSERT(trace.photodiode_id == same.photodiode_id);
    RC_ASSERT(trace.time_s == same.time_s);
    RC_ASSERT(trace.power_w == same.power_w);
    RC_ASSERT(trace.ambient_w == same.ambient_w);
  }
}

RC_GTEST_PROP(TraceProperties, ShuffledColumnsOfATableChangeNothing, ()) {
  const auto numbers = *rc::gen::container<std::vector<int>>(6, rc::gen::inRange(-1000, 1000));
  const std::vector<double> a(numbers.begin(), numbers.begin() + 3);
  const std::vector<double> b(numbers.begin() + 3, numbers.end());
  const TemporaryFolder folder;
  CsvReader table(
      folder.write("table.csv",
                   csv(shuffled({column("a", a), column("b", b), column("c", {1.0, 2.0, 3.0})}))),
      {"a", "b"});
  for (std::size_t row = 0; row < 3; ++row) {
    RC_ASSERT(table.next());
    RC_ASSERT(table.number("a") == a[row]);
    RC_ASSERT(table.number("b") == b[row]);
  }
  RC_ASSERT(!table.next());
}

RC_GTEST_PROP(TraceProperties, TwoChannelsOfOneFileAreAsTwoFiles, ()) {
  const Site site = roadside(2);
  const Trace one = random_trace(), two = random_trace();
  Column first = column("pd0_power_w", one.power_w), second = column("pd1_power_w", two.power_w);
  for (int hole = 0; hole < 20; ++hole) {
    const auto row = static_cast<std::size_t>(*rc::gen::inRange(0, 1600));
    (hole % 2 == 0 ? first : second).second[row] = hole % 3 == 0 ? "nan" : "";
  }
  const Column time = column("t_s", one.time_s);
  const auto both = traces_of(csv({time, first, second}), site);
  const auto alone_0 = traces_of(csv({time, first}), site);
  const auto alone_1 = traces_of(csv({time, second}), site);
  RC_ASSERT(both.size() == 2U);
  for (const auto& [found, alone] :
       {std::pair(both[0], alone_0.front()), std::pair(both[1], alone_1.front())}) {
    RC_ASSERT(found.photodiode == alone.photodiode);
    RC_ASSERT(found.time_s == alone.time_s);
    RC_ASSERT(found.power_w == alone.power_w);
    RC_ASSERT(found.rejected == alone.rejected);
  }
}

RC_GTEST_PROP(TraceProperties, LightCutInTwoHalvesGivesTheSameSpeed, ()) {
  const Site whole_site = roadside(1);
  Site halves_site = roadside(2);
  halves_site.channel->gain_db->mean -= 10.0 * std::log10(2.0);
  const Trace trace = random_trace();
  std::vector<double> half_w = trace.power_w;
  for (double& power_w : half_w) power_w *= 0.5;
  const Column time = column("t_s", trace.time_s);
  const VehicleResult whole =
      speed_of(traces_of(csv({time, column("power_w", trace.power_w)}), whole_site), whole_site);
  const VehicleResult halves =
      speed_of(traces_of(csv({time, column("pd0_power_w", half_w), column("pd1_power_w", half_w)}),
                         halves_site),
               halves_site);
  RC_ASSERT(!whole.withheld);
  RC_ASSERT(!halves.withheld);
  RC_ASSERT(agree(whole.speed.speed_mps, halves.speed.speed_mps, 1e-6));
  RC_ASSERT(agree(whole.speed.std_mps, halves.speed.std_mps, 1e-6));
}

}  // namespace
}  // namespace vildar
