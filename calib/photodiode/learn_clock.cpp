#include "calib/photodiode/learn_clock.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "calib/photodiode/light_fall.h"
#include "calib/photodiode/rim_crossing.h"
#include "calib/site/spreads.h"
#include "core/quantity.h"

namespace vildar {
namespace {

constexpr double kRimStd_rad = 0.0175;  // one degree
constexpr double kLikelyRimSpread_rad = 0.004;
constexpr double kLikelySpread_s = 0.001;
constexpr double kUnsureWay_s = 0.030;
constexpr double kReachSigmas = 3.0;

// One photodiode's light of one pass, and the moments at which the lamps may have left its view.
struct Sighting {
  std::size_t photodiode = 0;
  double way_std_s = 0.0, by_rim_s_per_rad = 0.0;
  std::vector<LightFall> falls;
};

using PassTimes = std::vector<Sighting>;

// The light of lamps on these sides; nothing where the trajectory does not tell when it goes.
std::optional<Sighting> sighting_of(const TimedPass& pass, std::span<const double> sides,
                                    const PowerTrace& trace, const Site& site) {
  const auto index = static_cast<std::size_t>(trace.photodiode);
  const PhotodiodeSite& photodiode = site.photodiodes[index];
  Sighting sighting{index, 0.0, 0.0, {}};
  std::vector<ExpectedFall> expected;
  double all_light = 0.0;
  for (const double side : sides) {
    const auto crossing = rim_crossing(pass.way, side, photodiode);
    if (!crossing || !(crossing->std_s < kUnsureWay_s)) return std::nullopt;
    const double light = std::pow(crossing->distance_m, -2);
    expected.push_back({crossing->time_s - photodiode.time_offset_s.mean, light});
    all_light += light;
    sighting.way_std_s = std::max(sighting.way_std_s, crossing->std_s);
    sighting.by_rim_s_per_rad +=
        crossing->by_half_view_s_per_rad / static_cast<double>(sides.size());
  }
  for (ExpectedFall& one : expected) one.share /= all_light;
  std::ranges::sort(expected, {}, &ExpectedFall::time_s);
  const double off_std_s = std::hypot(photodiode.time_offset_s.std, sighting.way_std_s,
                                      kRimStd_rad * sighting.by_rim_s_per_rad);
  sighting.falls =
      light_falls(trace, expected, 1.0 / sighting.by_rim_s_per_rad, kReachSigmas * off_std_s);
  return sighting;
}

double clearest_of(const Sighting& sighting) {
  double most = 0.0;
  for (const LightFall& fall : sighting.falls) most = std::max(most, fall.sigmas);
  return most;
}

// Two lamps leave the view one after the other; light that is nearly all of one, or of a vehicle
// that something covers, goes at once: as the light has it.
std::optional<Sighting> clearest_sighting(const TimedPass& pass, const PowerTrace& trace,
                                          const Site& site) {
  constexpr std::array kMiddle{0.0};
  constexpr std::array kBoth{-0.5, 0.5};
  auto at_once = sighting_of(pass, kMiddle, trace, site);
  if (!pass.way.problem.pairs) return at_once;
  auto one_by_one = sighting_of(pass, kBoth, trace, site);
  if (!at_once || !one_by_one) return std::nullopt;
  return clearest_of(*one_by_one) >= clearest_of(*at_once) ? one_by_one : at_once;
}

/// How much too late the photodiodes' light is, by the falls of one sighting: a mixture.
double log_likelihood(const Sighting& sighting, double late_s, double reach_s) {
  constexpr double kOdd = 0.2;  // share of sightings whose light falls for another reason
  double density = kOdd / (2.0 * reach_s);
  for (const LightFall& fall : sighting.falls) {
    const double std_s =
        std::hypot(fall.std_s, sighting.way_std_s, kRimStd_rad * sighting.by_rim_s_per_rad);
    density += (1.0 - kOdd) / static_cast<double>(sighting.falls.size()) *
               std::exp(-0.5 * std::pow((fall.late_s - late_s) / std_s, 2)) /
               (std::sqrt(2.0 * kPi) * std_s);
  }
  return std::log(density);
}

// Lateness on which most sightings agree.
double agreed_s(const std::vector<PassTimes>& passes, double prior_std_s) {
  const double reach_s = kReachSigmas * prior_std_s + 0.1;
  constexpr double kStep_s = 5e-4;
  double best_s = 0.0, most = -INFINITY;
  const auto steps = static_cast<int>(std::ceil(kReachSigmas * prior_std_s / kStep_s));
  for (int k = -steps; k <= steps; ++k) {
    const double late_s = k * kStep_s;
    double sum = -0.5 * std::pow(late_s / prior_std_s, 2);
    for (const PassTimes& pass : passes)
      for (const Sighting& sighting : pass) sum += log_likelihood(sighting, late_s, reach_s);
    if (sum > most) {
      most = sum;
      best_s = late_s;
    }
  }
  return best_s;
}

// The falls of a pass that lie near what most agree on, as a linear problem of the offset and of
// each photodiode's rim. A trajectory's error is the same for all photodiodes.
std::optional<LinearPass> linear_of(const PassTimes& pass, double agreed_s,
                                    std::size_t photodiodes) {
  constexpr double kNearSigmas = 4.0;
  std::vector<double> late_s;
  std::vector<const Sighting*> from;
  std::vector<double> own_std_s;
  for (const Sighting& sighting : pass) {
    const LightFall* nearest = nullptr;
    for (const LightFall& fall : sighting.falls)
      if (!nearest || std::abs(fall.late_s - agreed_s) < std::abs(nearest->late_s - agreed_s))
        nearest = &fall;
    if (!nearest) continue;
    const double std_s = std::hypot(std::hypot(nearest->std_s, sighting.way_std_s),
                                    kRimStd_rad * sighting.by_rim_s_per_rad, kLikelySpread_s);
    if (std::abs(nearest->late_s - agreed_s) > kNearSigmas * std_s) continue;
    late_s.push_back(nearest->late_s);
    own_std_s.push_back(nearest->std_s);
    from.push_back(&sighting);
  }
  if (from.empty()) return std::nullopt;
  const auto count = static_cast<Eigen::Index>(from.size());
  const auto unknowns = static_cast<Eigen::Index>(1 + photodiodes);
  Eigen::MatrixXd by_unknown = Eigen::MatrixXd::Zero(count, unknowns), covariance(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Sighting& one = *from[static_cast<std::size_t>(i)];
    // Light that comes late is read too late: the offset is less by as much.
    by_unknown(i, 0) = -1.0;
    by_unknown(i, 1 + static_cast<Eigen::Index>(one.photodiode)) = one.by_rim_s_per_rad;
    for (Eigen::Index j = 0; j < count; ++j)
      covariance(i, j) = one.way_std_s * from[static_cast<std::size_t>(j)]->way_std_s;
    covariance(i, i) += std::pow(own_std_s[static_cast<std::size_t>(i)], 2);
  }
  const Eigen::MatrixXd weight = covariance.inverse();
  const Eigen::Map<const Eigen::VectorXd> seen(late_s.data(), count);
  LinearPass linear;
  linear.information = by_unknown.transpose() * weight * by_unknown;
  linear.gradient = -by_unknown.transpose() * weight * seen;
  linear.shared_by_path = Eigen::MatrixXd::Identity(unknowns, unknowns);
  linear.shared = Eigen::VectorXd::Zero(unknowns);
  for (std::size_t k = 0; k < 1 + photodiodes; ++k) linear.members.push_back({k, 0.0});
  return linear;
}

std::vector<Population> populations_of(double prior_std_s, std::size_t photodiodes) {
  const auto population = [](double mean_std, double likely_spread) {
    Population one;
    one.mean = {0.0, mean_std};
    one.likely_spread = one.spread = likely_spread;
    one.spread_weight = 1.0;
    return one;
  };
  std::vector<Population> all{population(prior_std_s, kLikelySpread_s)};
  all.resize(1 + photodiodes, population(kRimStd_rad, kLikelyRimSpread_rad));
  return all;
}

}  // namespace

Outcome<ClockLearning> learn_clock(std::span<const TimedPass> passes, const Site& site) {
  ClockLearning learning;
  learning.site = site;
  const Uncertain before = site.photodiodes.front().time_offset_s;
  learning.clock.before = learning.clock.after = before;
  if (!(before.std > 0.0)) return Miss::unobservable;
  std::vector<PassTimes> timed;
  for (const TimedPass& pass : passes) {
    PassTimes times;
    bool falls = false;
    for (const PowerTrace& trace : pass.traces)
      if (auto sighting = clearest_sighting(pass, trace, site)) {
        falls = falls || !sighting->falls.empty();
        times.push_back(std::move(*sighting));
      }
    if (times.empty())
      ++learning.left_out["rim_not_reached"];
    else if (!falls)
      ++learning.left_out["light_does_not_fall"];
    else
      timed.push_back(std::move(times));
  }
  const std::size_t photodiodes = site.photodiodes.size();
  std::vector<LinearPass> told;
  const double agreed = agreed_s(timed, before.std);
  for (const PassTimes& pass : timed)
    if (auto linear = linear_of(pass, agreed, photodiodes))
      told.push_back(std::move(*linear));
    else
      ++learning.left_out["unlike_the_others"];
  LearnedClock& clock = learning.clock;
  for (;;) {
    clock.passes = static_cast<int>(told.size());
    if (clock.passes < kFewestClockPasses) return learning;
    std::vector<Population> populations = populations_of(before.std, photodiodes);
    const Learned learned = learn_spreads(told, populations);
    if (const auto odd = stranger(told, learned, populations)) {
      told.erase(told.begin() + static_cast<std::ptrdiff_t>(*odd));
      ++learning.left_out["unlike_the_others"];
      continue;
    }
    clock.mean_std_s = std::sqrt(learned.covariance(0, 0));
    clock.spread_s = populations.front().spread;
    clock.after = {before.mean + learned.means[0],
                   std::min(before.std, std::hypot(clock.mean_std_s, clock.spread_s))};
    for (PhotodiodeSite& photodiode : learning.site.photodiodes) {
      photodiode.time_offset_s.mean += learned.means[0];
      photodiode.time_offset_s.std = clock.after.std;
    }
    return learning;
  }
}

}  // namespace vildar
