#include "calib/sync/learn.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Dense>

#include "calib/site/spreads.h"
#include "estimate/joint_fit.h"

namespace vildar {
namespace {

constexpr std::size_t kFewest = 5;
// Of the variance of lengths and beams, what a site's vehicles have in common (as calib/site has
// it); the rest parts them, at the weight of four passes.
constexpr double kCommonShare = 0.5;
constexpr double kSpreadWeight = 4.0;
// What is one for all passes may still seem to differ by what no model holds.
constexpr double kLikelyOffsetSpread_s = 0.001, kLikelyRatioSpread = 0.005;

using Kind = SharedLight::Kind;

struct Unknown {
  Kind kind;
  int index;
  double prior_std;
  double moved = 0.0;  ///< of its mean in the site so far
};

/// What one pass says, its own unknowns eliminated.
struct Say {
  LinearPass linear;
  Eigen::VectorXd by_scale;
  double scale_std = 0.0, closing_mps = 0.0, relative_speed_std = 0.0;
};

double relative_speed_std(const Trajectory& way) {
  const MotionState state = way.at(best_time_s(way, way.from_s, way.to_s));
  return state.speed_std_mps / std::abs(state.over_ground_mps);
}

std::size_t place_of(const SharedLight& shared, std::vector<Unknown>& unknowns) {
  const auto same = [&](const Unknown& unknown) {
    return unknown.kind == shared.kind && unknown.index == shared.index;
  };
  auto place = std::ranges::find_if(unknowns, same);
  if (place == unknowns.end())
    place = unknowns.insert(unknowns.end(), {shared.kind, shared.index, shared.prior_std});
  return static_cast<std::size_t>(place - unknowns.begin());
}

Say say_of(const JointFit& fit, std::vector<Unknown>& unknowns) {
  const auto count = static_cast<Eigen::Index>(fit.shared.size());
  Eigen::VectorXd off(count), priors(count);
  Say say;
  say.by_scale.resize(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const SharedLight& shared = fit.shared[static_cast<std::size_t>(i)];
    say.linear.members.push_back({place_of(shared, unknowns), 0.0});
    off[i] = shared.off;
    priors[i] = std::pow(shared.prior_std, -2);
    say.by_scale[i] = shared.by_scale;
  }
  // The fit without its priors, which the populations stand for. Scaled by these; rounding must not
  // let a pass say less than nothing.
  const Eigen::VectorXd scale = priors.cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd posterior =
      scale.asDiagonal() * fit.shared_covariance.inverse() * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> own(posterior -
                                                           Eigen::MatrixXd::Identity(count, count));
  const Eigen::VectorXd root = scale.cwiseInverse();
  say.linear.information = root.asDiagonal() * own.eigenvectors() *
                           own.eigenvalues().cwiseMax(0.0).asDiagonal() *
                           own.eigenvectors().transpose() * root.asDiagonal();
  say.linear.gradient = -priors.cwiseProduct(off);
  say.linear.shared_by_path = Eigen::MatrixXd::Identity(count, count);
  say.linear.shared = off;
  const Trajectory& way = fit.trajectory;
  say.scale_std = way.scale_std();
  say.closing_mps = std::abs(way.at(0.5 * (way.from_s + way.to_s)).closing_mps);
  say.relative_speed_std = relative_speed_std(way);
  return say;
}

Population population_of(const Unknown& unknown) {
  Population population;
  if (unknown.kind == Kind::beam) {
    population.mean = {0.0, std::sqrt(kCommonShare) * unknown.prior_std};
    population.likely_spread = std::sqrt(1.0 - kCommonShare) * unknown.prior_std;
    population.spread_weight = kSpreadWeight;
  } else {
    population.mean = {-unknown.moved, unknown.prior_std};
    population.likely_spread =
        unknown.kind == Kind::time_offset_s ? kLikelyOffsetSpread_s : kLikelyRatioSpread;
    population.spread_weight = 1.0;
  }
  population.spread = population.likely_spread;
  return population;
}

struct Combined {
  std::vector<Population> populations;
  Learned learned;
};

/// The populations behind the passes; leaves out, worst first, passes that are unlike the others.
Combined combine(std::vector<Say>& says, const std::vector<Unknown>& unknowns, int& strangers) {
  for (;;) {
    Combined found;
    for (const Unknown& unknown : unknowns) found.populations.push_back(population_of(unknown));
    std::vector<LinearPass> linear;
    for (const Say& say : says) linear.push_back(say.linear);
    found.learned = learn_spreads(linear, found.populations);
    const auto odd = stranger(linear, found.learned, found.populations);
    if (!odd || says.size() <= kFewest) return found;
    says.erase(says.begin() + static_cast<std::ptrdiff_t>(*odd));
    ++strangers;
  }
}

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

Uncertain& value_in(Site& site, const Unknown& unknown, std::size_t photodiode) {
  PhotodiodeSite& diode = site.photodiodes[photodiode];
  return unknown.kind == Kind::time_offset_s ? diode.time_offset_s : diode.gain_ratio;
}

/// Photodiodes whose entry in the site file is this unknown's.
std::vector<std::size_t> photodiodes_of(const Unknown& unknown, const Site& site) {
  if (unknown.kind == Kind::log_gain_ratio) return {static_cast<std::size_t>(unknown.index)};
  std::vector<std::size_t> all(site.photodiodes.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

void move_mean(Site& site, const Unknown& unknown, double by) {
  for (const std::size_t photodiode : photodiodes_of(unknown, site)) {
    Uncertain& value = value_in(site, unknown, photodiode);
    if (unknown.kind == Kind::time_offset_s)
      value.mean += by;
    else {  // relative sigma is what the fits take as the prior's
      value.mean *= std::exp(by);
      value.std *= std::exp(by);
    }
  }
}

struct Round {
  std::vector<Say> says;
  std::map<std::string, int> left_out;
};

Round fit_all(std::span<const LitPass> passes, const Site& site, std::vector<Unknown>& unknowns) {
  Round round;
  for (const LitPass& pass : passes) {
    const auto outcome = fit_joint(pass.way, site, pass.power, pass.way.from_s, pass.way.to_s);
    if (const Miss* miss = std::get_if<Miss>(&outcome))
      ++round.left_out[std::string(name_of(*miss))];
    else
      round.says.push_back(say_of(std::get<JointFit>(outcome), unknowns));
  }
  return round;
}

bool has_unknown(const Site& site) {
  return std::ranges::any_of(site.photodiodes, [&](const PhotodiodeSite& photodiode) {
    return photodiode.time_offset_s.std > 0.0 ||
           (&photodiode != &site.photodiodes.front() && photodiode.gain_ratio.std > 0.0);
  });
}

bool tells_of(const Say& say, std::size_t unknown) {
  return std::ranges::count(say.linear.members, unknown, &Membership::population) > 0;
}

/// What the passes do not average out, as a sigma of the unknown.
double common_std(std::span<const Say> says, std::size_t unknown, Kind kind, const Site& site) {
  std::vector<double> by_scale, scale_stds, speeds_mps;
  for (const Say& say : says)
    for (std::size_t i = 0; i < say.linear.members.size(); ++i)
      if (say.linear.members[i].population == unknown) {
        by_scale.push_back(say.by_scale[static_cast<Eigen::Index>(i)]);
        scale_stds.push_back(say.scale_std);
        speeds_mps.push_back(say.closing_mps);
      }
  const double of_scale = median_of(by_scale) * std::sqrt(kCommonShare) * median_of(scale_stds);
  const double of_place = kind == Kind::time_offset_s
                              ? site.photodiodes.front().position_m[0].std / median_of(speeds_mps)
                              : 0.0;
  return std::hypot(of_scale, of_place);
}

double median_speed_std(std::span<const Say> says) {
  std::vector<double> stds;
  for (const Say& say : says) stds.push_back(say.relative_speed_std);
  return stds.empty() ? 0.0 : median_of(stds);
}

/// Writes an unknown's new sigma to the site and tells what became of it.
LearnedPhotodiode settle(const Unknown& unknown, double std, const Site& before, Site& site) {
  const std::vector<std::size_t> where = photodiodes_of(unknown, site);
  const bool offset = unknown.kind == Kind::time_offset_s;
  for (const std::size_t photodiode : where) {
    Uncertain& value = value_in(site, unknown, photodiode);
    value.std = offset ? std : std * value.mean;
  }
  LearnedPhotodiode told;
  told.key = offset ? "photodiodes[].time_offset_s"
                    : "photodiodes[" + std::to_string(unknown.index) + "].gain_ratio";
  told.unit = offset ? "s" : "";
  Site given = before;
  told.before = value_in(given, unknown, where.front());
  told.after = value_in(site, unknown, where.front());
  return told;
}

}  // namespace

Outcome<PhotodiodeLearning> learn_photodiodes(std::span<const LitPass> passes, const Site& site) {
  constexpr int kRounds = 6;
  constexpr double kSettled = 0.1;  // sigmas
  if (!has_unknown(site)) return Miss::unobservable;
  PhotodiodeLearning learning;
  learning.site = site;
  std::vector<Unknown> unknowns;
  Round round;
  Combined found;
  for (int r = 0; r < kRounds; ++r) {
    round = fit_all(passes, learning.site, unknowns);
    if (round.says.size() < kFewest) return Miss::too_few_samples;
    if (r == 0) learning.speed_std_before = median_speed_std(round.says);
    int strangers = 0;
    found = combine(round.says, unknowns, strangers);
    if (strangers > 0) round.left_out["unlike_the_others"] = strangers;
    double most = 0.0;
    for (std::size_t i = 0; i < unknowns.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      if (unknowns[i].kind == Kind::beam) continue;
      const double step = found.learned.means[at];
      move_mean(learning.site, unknowns[i], step);
      unknowns[i].moved += step;
      most = std::max(most, std::abs(step) / std::sqrt(found.learned.covariance(at, at)));
    }
    learning.settled = most < kSettled;
    if (learning.settled) break;
  }
  learning.left_out = round.left_out;
  learning.passes = static_cast<int>(round.says.size());
  for (std::size_t i = 0; i < unknowns.size(); ++i) {
    if (unknowns[i].kind == Kind::beam) continue;
    const auto at = static_cast<Eigen::Index>(i);
    const double std =
        std::sqrt(found.learned.covariance(at, at) + std::pow(found.populations[i].spread, 2) +
                  std::pow(common_std(round.says, i, unknowns[i].kind, site), 2));
    learning.quantities.push_back(
        settle(unknowns[i], std::min(unknowns[i].prior_std, std), site, learning.site));
    learning.quantities.back().passes = static_cast<int>(
        std::ranges::count_if(round.says, [&](const Say& say) { return tells_of(say, i); }));
  }
  learning.speed_std_after = median_speed_std(fit_all(passes, learning.site, unknowns).says);
  return learning;
}

}  // namespace vildar
