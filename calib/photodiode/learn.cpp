#include "calib/photodiode/learn.h"

#include <algorithm>
#include <cmath>

#include "calib/site/spreads.h"
#include "estimate/joint_fit.h"

namespace vildar {
namespace {

// Photodiodes that look at a lamp under other angles differ by so much from pass to pass; the
// weight of that guess is one pass.
constexpr double kLikelySpread = 0.005;

double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Fitted {
  std::vector<JointFit> fits;
  std::map<std::string, int> left_out;

  double median_speed_std() const {
    std::vector<double> stds;
    for (const JointFit& fit : fits) {
      const Trajectory& way = fit.trajectory;
      const MotionState state = way.at(best_time_s(way, way.from_s, way.to_s));
      stds.push_back(state.speed_std_mps / std::abs(state.over_ground_mps));
    }
    return stds.empty() ? 0.0 : median_of(stds);
  }
};

Fitted fit_all(std::span<const LitPass> passes, const Site& site) {
  Fitted fitted;
  for (const LitPass& pass : passes) {
    auto outcome = fit_joint(pass.way, site, pass.power, pass.way.from_s, pass.way.to_s);
    if (const Miss* miss = std::get_if<Miss>(&outcome))
      ++fitted.left_out[std::string(name_of(*miss))];
    else
      fitted.fits.push_back(std::get<JointFit>(std::move(outcome)));
  }
  return fitted;
}

/// What a pass says of one ratio without the prior that it was fitted with.
LinearPass linear_of(const PassGainRatio& ratio) {
  const double prior = std::pow(ratio.prior_std, -2);
  LinearPass pass;
  pass.information = Eigen::MatrixXd::Constant(1, 1, std::pow(ratio.std, -2) - prior);
  pass.gradient = Eigen::VectorXd::Constant(1, -ratio.log_off * prior);
  pass.shared_by_path = Eigen::MatrixXd::Ones(1, 1);
  pass.shared = Eigen::VectorXd::Constant(1, ratio.log_off);
  pass.members = {{0, 0.0}};
  return pass;
}

struct FoundRatio {
  Learned learned;
  Population population;
  int passes = 0, strangers = 0;
};

FoundRatio learn_ratio(std::vector<LinearPass> passes, double prior_std) {
  FoundRatio found;
  for (;; ++found.strangers) {
    found.population.mean = {0.0, prior_std};
    found.population.likely_spread = found.population.spread = kLikelySpread;
    found.population.spread_weight = 1.0;
    std::vector<Population> populations{found.population};
    found.learned = learn_spreads(passes, populations);
    found.population = populations.front();
    found.passes = static_cast<int>(passes.size());
    const auto odd = stranger(passes, found.learned, populations);
    if (!odd || found.passes <= kFewestGainPasses) return found;
    passes.erase(passes.begin() + static_cast<std::ptrdiff_t>(*odd));
  }
}

LearnedGain settle(std::size_t photodiode, const FoundRatio& found, Site& site) {
  Uncertain& ratio = site.photodiodes[photodiode].gain_ratio;
  LearnedGain gain;
  gain.key = "photodiodes[" + std::to_string(photodiode) + "].gain_ratio";
  gain.before = gain.after = ratio;
  gain.passes = found.passes;
  if (found.passes < kFewestGainPasses) return gain;
  const double mean = ratio.mean * std::exp(found.learned.means[0]);
  gain.mean_std = mean * std::sqrt(found.learned.covariance(0, 0));
  gain.spread = mean * found.population.spread;
  // What the file states is of the gain; passes that differ by more are unlike in something else,
  // which stands in for it.
  const double told_std = mean * ratio.std / ratio.mean;
  const double found_std = std::hypot(gain.mean_std, gain.spread);
  gain.differs = gain.spread > told_std;
  gain.after = {mean, gain.differs ? found_std : std::min(found_std, told_std)};
  ratio = gain.after;
  site.photodiodes[photodiode].gain_ratio_told = true;
  return gain;
}

}  // namespace

Outcome<GainLearning> learn_gains(std::span<const LitPass> passes, const Site& site) {
  const auto unknown = [&](std::size_t photodiode) {
    return photodiode > 0 && site.photodiodes[photodiode].gain_ratio.std > 0.0;
  };
  GainLearning learning;
  learning.site = site;
  const Fitted fitted = fit_all(passes, site);
  learning.left_out = fitted.left_out;
  learning.passes = static_cast<int>(fitted.fits.size());
  bool any = false;
  for (std::size_t photodiode = 0; photodiode < site.photodiodes.size(); ++photodiode) {
    if (!unknown(photodiode)) continue;
    any = true;
    std::vector<LinearPass> told;
    double prior_std = 0.0;
    for (const JointFit& fit : fitted.fits)
      for (const PassGainRatio& ratio : fit.gain_ratios)
        if (ratio.photodiode == static_cast<int>(photodiode)) {
          told.push_back(linear_of(ratio));
          prior_std = ratio.prior_std;
        }
    if (told.empty()) continue;
    const FoundRatio found = learn_ratio(std::move(told), prior_std);
    if (found.strangers > 0) learning.left_out["unlike_the_others"] += found.strangers;
    learning.gains.push_back(settle(photodiode, found, learning.site));
  }
  if (!any) return Miss::unobservable;
  learning.speed_std_before = fitted.median_speed_std();
  learning.speed_std_after = fit_all(passes, learning.site).median_speed_std();
  return learning;
}

}  // namespace vildar
