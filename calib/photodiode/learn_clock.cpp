#include "calib/photodiode/learn_clock.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/LU>

#include "calib/photodiode/rim_sighting.h"
#include "calib/site/spreads.h"
#include "core/quantity.h"

namespace vildar {
namespace {

constexpr double kLikelyRimSpread_rad = 0.004;
constexpr double kLikelySpread_s = 0.001;
constexpr double kReachSigmas = 3.0, kFarthest_s = 600.0;
constexpr const char* kUnlike = "unlike_the_others";

using PassTimes = std::vector<RimSighting>;

double std_of(const LightFall& fall, const RimSighting& sighting) {
  return std::hypot(std::hypot(fall.std_s, kLikelySpread_s), sighting.way_std_s,
                    kRimStd_rad * sighting.by_rim_s_per_rad);
}

const char* name_of(Silent reason) {
  switch (reason) {
    case Silent::rim_not_reached: return "rim_not_reached";
    case Silent::way_unsure: return "way_unsure";
    case Silent::light_does_not_fall: return "light_does_not_fall";
  }
  return "";
}

std::variant<PassTimes, Silent> times_of(const TimedPass& pass, const Site& site, double reach_s) {
  PassTimes times;
  Silent reason = Silent::rim_not_reached;
  for (const PowerTrace& trace : pass.traces) {
    auto found = rim_sighting(pass.way, trace, site, reach_s);
    if (auto* sighting = std::get_if<RimSighting>(&found))
      times.push_back(std::move(*sighting));
    else
      reason = std::max(reason, std::get<Silent>(found));
  }
  if (times.empty()) return reason;
  return times;
}

// Of light that is all so late, ln of the likelihood of one sighting's falls: some fall for another
// reason.
double log_likelihood(const RimSighting& sighting, double late_s, double reach_s) {
  constexpr double kOdd = 0.2;
  double density = kOdd / (2.0 * reach_s);
  for (const LightFall& fall : sighting.falls) {
    const double std_s = std_of(fall, sighting);
    density += (1.0 - kOdd) / static_cast<double>(sighting.falls.size()) *
               std::exp(-0.5 * std::pow((fall.late_s - late_s) / std_s, 2)) /
               (std::sqrt(2.0 * kPi) * std_s);
  }
  return std::log(density);
}

// About which times most falls lie, most first.
std::vector<double> crowded_s(const std::vector<PassTimes>& passes) {
  constexpr double kAbout_s = 0.02;
  constexpr std::size_t kMost = 20;
  std::vector<double> late_s;
  for (const PassTimes& pass : passes)
    for (const RimSighting& sighting : pass)
      for (const LightFall& fall : sighting.falls) late_s.push_back(fall.late_s);
  std::ranges::sort(late_s);
  std::vector<std::pair<std::ptrdiff_t, double>> crowds;
  auto first = late_s.begin(), last = first;
  for (const double one_s : late_s) {
    while (*first < one_s - kAbout_s) ++first;
    while (last != late_s.end() && *last < one_s + kAbout_s) ++last;
    crowds.push_back({last - first, one_s});
  }
  std::ranges::sort(crowds, std::greater<>());
  std::vector<double> found;
  for (const auto& [count, one_s] : crowds)
    if (found.size() < kMost && std::ranges::none_of(found, [at_s = one_s](double other_s) {
          return std::abs(other_s - at_s) < kAbout_s;
        }))
      found.push_back(one_s);
  return found;
}

// Lateness on which most sightings agree.
double agreed_s(const std::vector<PassTimes>& passes, double prior_std_s, double reach_s) {
  constexpr double kAbout_s = 0.03, kStep_s = 5e-4;
  double best_s = 0.0, most = -INFINITY;
  for (const double about_s : crowded_s(passes))
    for (double late_s = about_s - kAbout_s; late_s <= about_s + kAbout_s; late_s += kStep_s) {
      double sum = -0.5 * std::pow(late_s / prior_std_s, 2);
      for (const PassTimes& pass : passes)
        for (const RimSighting& sighting : pass) sum += log_likelihood(sighting, late_s, reach_s);
      if (!(sum > most)) continue;
      most = sum;
      best_s = late_s;
    }
  return best_s;
}

// The falls of a pass that lie near what most agree on, as a linear problem of the offset and of
// each photodiode's rim. A trajectory's error is the same for all photodiodes.
std::optional<LinearPass> linear_of(const PassTimes& pass, double agreed_s,
                                    std::size_t photodiodes) {
  constexpr double kNearSigmas = 4.0;
  struct Used {
    const RimSighting& sighting;
    const LightFall& fall;
  };
  std::vector<Used> used;
  for (const RimSighting& sighting : pass) {
    const LightFall& nearest = *std::ranges::min_element(
        sighting.falls, {},
        [&](const LightFall& fall) { return std::abs(fall.late_s - agreed_s); });
    if (std::abs(nearest.late_s - agreed_s) < kNearSigmas * std_of(nearest, sighting))
      used.push_back({sighting, nearest});
  }
  if (used.empty()) return std::nullopt;
  const auto count = static_cast<Eigen::Index>(used.size());
  const auto unknowns = static_cast<Eigen::Index>(1 + photodiodes);
  Eigen::MatrixXd by_unknown = Eigen::MatrixXd::Zero(count, unknowns);
  Eigen::VectorXd late_s(count), way_std_s(count), own_std_s(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto& [sighting, fall] = used[static_cast<std::size_t>(i)];
    // Light that comes late is read too late: the offset is less by as much.
    by_unknown(i, 0) = -1.0;
    by_unknown(i, 1 + static_cast<Eigen::Index>(sighting.photodiode)) = sighting.by_rim_s_per_rad;
    late_s[i] = fall.late_s;
    way_std_s[i] = sighting.way_std_s;
    own_std_s[i] = fall.std_s;
  }
  Eigen::MatrixXd covariance = way_std_s * way_std_s.transpose();
  covariance.diagonal() += own_std_s.cwiseAbs2();
  const Eigen::MatrixXd weight = covariance.inverse();
  LinearPass linear;
  linear.information = by_unknown.transpose() * weight * by_unknown;
  linear.gradient = -by_unknown.transpose() * weight * late_s;
  linear.shared_by_path = Eigen::MatrixXd::Identity(unknowns, unknowns);
  linear.shared = Eigen::VectorXd::Zero(unknowns);
  for (std::size_t k = 0; k < 1 + photodiodes; ++k) linear.members.push_back({k, 0.0});
  return linear;
}

// Of the offset, then of each photodiode's rim.
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

struct FoundOffset {
  int passes = 0;
  Learned learned;
  double spread_s = 0.0;
};

// Nothing where too few passes tell of it.
std::optional<FoundOffset> learn_offset(std::vector<LinearPass> told, double prior_std_s,
                                        std::size_t photodiodes) {
  for (;;) {
    FoundOffset found;
    found.passes = static_cast<int>(told.size());
    if (found.passes < kFewestClockPasses) return std::nullopt;
    std::vector<Population> populations = populations_of(prior_std_s, photodiodes);
    found.learned = learn_spreads(told, populations);
    found.spread_s = populations.front().spread;
    const auto odd = stranger(told, found.learned, populations);
    if (!odd) return found;
    told.erase(told.begin() + static_cast<std::ptrdiff_t>(*odd));
  }
}

}  // namespace

Outcome<ClockLearning> learn_clock(std::span<const TimedPass> passes, const Site& site) {
  constexpr std::size_t kMostOdd = 3;  // one pass in so many
  if (site.photodiodes.empty()) return Miss::unobservable;
  const Uncertain before = site.photodiodes.front().time_offset_s;
  for (const PhotodiodeSite& photodiode : site.photodiodes)
    if (!(photodiode.time_offset_s == before)) return Miss::outside_model;
  if (!(before.std > 0.0)) return Miss::unobservable;
  ClockLearning learning{site, {false, before, before, 0.0, 0.0, 0}, {}};
  const double reach_s = std::min(kFarthest_s, kReachSigmas * before.std);
  std::vector<PassTimes> timed;
  for (const TimedPass& pass : passes) {
    auto times = times_of(pass, site, reach_s);
    if (const Silent* reason = std::get_if<Silent>(&times))
      ++learning.left_out[name_of(*reason)];
    else
      timed.push_back(std::get<PassTimes>(std::move(times)));
  }
  const std::size_t photodiodes = site.photodiodes.size();
  std::vector<LinearPass> told;
  const double agreed = agreed_s(timed, before.std, reach_s);
  for (const PassTimes& pass : timed)
    if (auto linear = linear_of(pass, agreed, photodiodes)) told.push_back(std::move(*linear));
  LearnedClock& clock = learning.clock;
  clock.passes = static_cast<int>(told.size());
  const auto found = learn_offset(std::move(told), before.std, photodiodes);
  if (found) clock.passes = found->passes;
  const auto odd = timed.size() - static_cast<std::size_t>(clock.passes);
  if (odd > 0) learning.left_out[kUnlike] = static_cast<int>(odd);
  if (!found || kMostOdd * odd > timed.size()) return learning;
  clock.learned = true;
  clock.mean_std_s = std::sqrt(found->learned.covariance(0, 0));
  clock.spread_s = found->spread_s;
  clock.after = {before.mean + found->learned.means[0],
                 std::min(before.std, std::hypot(clock.mean_std_s, clock.spread_s))};
  for (PhotodiodeSite& photodiode : learning.site.photodiodes)
    photodiode.time_offset_s = clock.after;
  return learning;
}

}  // namespace vildar
