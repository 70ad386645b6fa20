#include "calib/photodiode/rim_sighting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "calib/photodiode/rim_crossing.h"

namespace vildar {
namespace {

// Falls further apart than this are looked for one by one: the light between is no exponential.
constexpr double kFarApart_s = 0.040;

// When the light of lamps on some sides is expected to go.
struct Expected {
  ExpectedFall fall;
  double way_std_s = 0.0, by_rim_s_per_rad = 0.0;

  double apart_s() const { return fall.lamps.back().time_s - fall.lamps.front().time_s; }
  double middle_s() const { return 0.5 * (fall.lamps.back().time_s + fall.lamps.front().time_s); }
};

std::variant<Expected, Silent> expected_of(const Trajectory& way, std::span<const double> sides,
                                           const PhotodiodeSite& photodiode) {
  constexpr double kUnsure_s = 0.030;
  Expected expected;
  double all_light = 0.0;
  for (const double side : sides) {
    const auto crossing = rim_crossing(way, side, photodiode);
    if (!crossing) return Silent::rim_not_reached;
    if (!(crossing->std_s < kUnsure_s)) return Silent::way_unsure;
    const double light = std::pow(crossing->distance_m, -2);
    expected.fall.lamps.push_back({crossing->time_s - photodiode.time_offset_s.mean, light});
    all_light += light;
    expected.way_std_s = std::max(expected.way_std_s, crossing->std_s);
    expected.by_rim_s_per_rad +=
        crossing->by_half_view_s_per_rad / static_cast<double>(sides.size());
  }
  for (LampFall& lamp : expected.fall.lamps) lamp.share /= all_light;
  std::ranges::sort(expected.fall.lamps, {}, &LampFall::time_s);
  expected.fall.turn_rad_per_s = 1.0 / expected.by_rim_s_per_rad;
  return expected;
}

double clearest(const std::vector<LightFall>& falls) {
  double most = 0.0;
  for (const LightFall& fall : falls) most = std::max(most, fall.sigmas);
  return most;
}

// Of single falls, late after `middle_s`, those that lie apart as two lamps' do; late as these.
std::vector<LightFall> paired(const std::vector<LightFall>& singles, double middle_s,
                              const Expected& both) {
  constexpr double kSigmas = 3.0, kShare = 0.1, kLeast_s = 0.002;
  std::vector<LightFall> pairs;
  for (auto first = singles.begin(); first != singles.end(); ++first)
    for (auto second = first + 1; second != singles.end(); ++second) {
      const double off_s = second->late_s - first->late_s - both.apart_s();
      const double std_s = std::hypot(first->std_s, second->std_s);
      if (std::abs(off_s) > kSigmas * std_s + kShare * both.apart_s() + kLeast_s) continue;
      pairs.push_back({0.5 * (first->late_s + second->late_s) + middle_s - both.middle_s(),
                       0.5 * std_s, std::min(first->sigmas, second->sigmas)});
    }
  return pairs;
}

}  // namespace

std::variant<RimSighting, Silent> rim_sighting(const Trajectory& way, const PowerTrace& trace,
                                               const Site& site, double reach_s) {
  constexpr std::array kMiddle{0.0};
  constexpr std::array kBoth{-0.5, 0.5};
  constexpr double kReachSigmas = 3.0;
  const auto index = static_cast<std::size_t>(trace.photodiode);
  const PhotodiodeSite& photodiode = site.photodiodes.at(index);
  const auto sighting_of = [&](const Expected& expected, std::vector<LightFall> falls) {
    return RimSighting{index, expected.way_std_s, expected.by_rim_s_per_rad, std::move(falls)};
  };
  const auto middle_or = expected_of(way, kMiddle, photodiode);
  const auto both_or = way.problem.pairs ? expected_of(way, kBoth, photodiode) : middle_or;
  for (const auto* one : {&middle_or, &both_or})
    if (const Silent* reason = std::get_if<Silent>(one)) return *reason;
  const Expected& middle = std::get<Expected>(middle_or);
  const Expected& both = std::get<Expected>(both_or);
  const double reach =
      reach_s + kReachSigmas * std::hypot(both.way_std_s, kRimStd_rad * both.by_rim_s_per_rad);
  const double middle_s = middle.fall.lamps.front().time_s;
  if (!way.problem.pairs) {
    std::vector<LightFall> falls = light_falls(trace, middle.fall, reach);
    if (falls.empty()) return Silent::light_does_not_fall;
    return sighting_of(middle, std::move(falls));
  }
  const std::vector<LightFall> singles = light_falls(trace, middle.fall, reach + both.apart_s());
  const std::vector<LightFall> pairs = paired(singles, middle_s, both);
  const std::vector<LightFall> together = both.apart_s() > kFarApart_s
                                              ? std::vector<LightFall>{}
                                              : light_falls(trace, both.fall, reach);
  if (singles.empty() && together.empty()) return Silent::light_does_not_fall;
  // A fall that has its partner is of one lamp alone.
  if (!pairs.empty()) return sighting_of(both, together.empty() ? pairs : together);
  return clearest(together) >= clearest(singles) ? sighting_of(both, together)
                                                 : sighting_of(middle, singles);
}

}  // namespace vildar
