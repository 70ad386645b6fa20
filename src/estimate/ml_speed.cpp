#include "estimate/ml_speed.h"

#include <algorithm>
#include <cmath>

#include "estimate/beam_doubt.h"
#include "estimate/power_estimators.h"
#include "estimate/series_blocks.h"
#include "estimate/speed_gate.h"
#include "optics/road.h"

namespace vildar {
namespace {

SeriesBlocks blocks_of(const PowerSeries& series) {
  constexpr double kBlock_s = 0.010;
  double squares_w2 = 0.0;
  const std::size_t n = series.time_s.size();
  for (std::size_t i = 1; i < n; ++i)
    squares_w2 += 0.5 * std::pow(series.power_w[i] - series.power_w[i - 1], 2);
  return series_blocks(series, kBlock_s, std::sqrt(squares_w2 / static_cast<double>(n - 1)));
}

PowerProblem problem_of(const SeriesBlocks& blocks, const PowerCase& known) {
  PowerProblem problem{blocks.time_s, blocks.power_w, blocks.sigma_w, {}, nothing_known(), 0.0};
  problem.reference_s = 0.5 * (blocks.time_s.front() + blocks.time_s.back());
  problem.setting.cosine_exponent = known.law.cosine_exponent;
  problem.known[kPowerLogGain] = Uncertain{std::log(known.law.gain_w), known.log_gain_std};
  problem.known[kPowerExponent] = Uncertain{known.law.path_loss_exponent, known.exponent_std};
  problem.known[kPowerAcceleration] = Uncertain{0.0, 1.5};
  const double across_m = known.lateral_m.mean - known.receiver_m.y();
  const double below_m = known.lamp_height_m.mean - known.receiver_m.z();
  if (known.bend == 0.0) {
    const double d_m = known.perpendicular_m();
    problem.known[kPowerPerpendicular] = Uncertain{
        d_m,
        d_m > 0.0
            ? std::hypot(across_m * known.lateral_m.std, below_m * known.lamp_height_m.std) / d_m
            : known.lateral_m.std};
  } else {
    problem.setting.curved = true;
    problem.setting.straight_m = known.straight_m;
    problem.setting.height_m = std::abs(below_m);
    const double side = known.bend > 0.0 ? 1.0 : -1.0;
    problem.known[kPowerPerpendicular] = Uncertain{side * across_m, known.lateral_m.std};
    problem.known[kPowerRadius] = Uncertain{known.lane_radius_m(), known.radius_m.std};
  }
  return problem;
}

// The speed with the background lifted by some of its sigmas, and the weight of this in the
// posterior.
struct Lifted {
  double lift = 0.0, log_speed = 0.0, log_std = 0.0, range_m = 0.0;
  double chi2 = 0.0, chi2_per_dof = 0.0;
  double prior_chi2 = 0.0;
  PassMotion motion;
};

std::variant<Lifted, Miss> fit_lifted(const SeriesBlocks& blocks, const PowerCase& known,
                                      double lift, double background_std_w) {
  SeriesBlocks lifted = blocks;
  for (double& power_w : lifted.power_w) power_w -= lift * background_std_w;
  const PowerProblem problem = problem_of(lifted, known);
  const auto outcome = estimate_max_likelihood(problem);
  if (const auto* refusal = std::get_if<PowerRefusal>(&outcome)) return refusal->miss;
  const auto& estimate = std::get<PowerEstimate>(outcome);
  if (!(estimate.speed_mps() > 0.0)) return Miss::outside_model;
  Lifted found;
  found.lift = lift;
  found.log_speed = std::log(estimate.speed_mps());
  found.log_std = estimate.speed_sigma_mps() / estimate.speed_mps() *
                  std::sqrt(std::max(1.0, estimate.chi2_per_dof));
  found.range_m = estimate.value[kPowerRange];
  found.motion = {estimate.reference_s, estimate.speed_mps(), found.range_m + known.receiver_m.x(),
                  estimate.value[kPowerAcceleration]};
  found.chi2_per_dof = estimate.chi2_per_dof;
  for (int p = 0; p < kPowerParameters; ++p)
    if (const auto& prior = problem.known[static_cast<std::size_t>(p)]; prior && prior->std > 0.0)
      found.prior_chi2 += std::pow((estimate.value[p] - prior->mean) / prior->std, 2);
  // Speed and range alone have no prior.
  const double degrees = static_cast<double>(blocks.time_s.size()) - 2.0;
  found.chi2 = estimate.chi2_per_dof * degrees + lift * lift;
  return found;
}

const Lifted& likeliest(const std::vector<Lifted>& fits) {
  return *std::min_element(fits.begin(), fits.end(),
                           [](const Lifted& a, const Lifted& b) { return a.chi2 < b.chi2; });
}

// The background is one more unknown with a prior, and the speed can have two modes in it: the
// posterior is summed over a grid, a coarse one first and a fine one where that has weight.
std::variant<std::vector<Lifted>, Miss> fits_over_background(const SeriesBlocks& blocks,
                                                             const PowerCase& known,
                                                             double background_std_w) {
  constexpr double kWidest = 3.0, kCoarse = 0.5, kNegligible = 25.0;  // the last of chi-square
  constexpr double kHarmless = 0.002;                                 // of the least light
  const double least_w = *std::min_element(blocks.power_w.begin(), blocks.power_w.end());
  if (!(background_std_w > kHarmless * least_w)) {
    const auto only = fit_lifted(blocks, known, 0.0, background_std_w);
    if (const Miss* miss = std::get_if<Miss>(&only)) return *miss;
    return std::vector{std::get<Lifted>(only)};
  }
  const auto grid = [&](double from, double to, double step) {
    std::vector<Lifted> fits;
    for (double lift = from; lift <= to + 1e-9; lift += step) {
      const auto fit = fit_lifted(blocks, known, lift, background_std_w);
      if (const auto* lifted = std::get_if<Lifted>(&fit)) fits.push_back(*lifted);
    }
    return fits;
  };
  const std::vector<Lifted> coarse = grid(-kWidest, kWidest, kCoarse);
  if (coarse.empty()) return Miss::outside_model;
  const double least = likeliest(coarse).chi2;
  double low = kWidest, high = -kWidest;
  for (const Lifted& fit : coarse)
    if (fit.chi2 < least + kNegligible) {
      low = std::min(low, fit.lift - kCoarse);
      high = std::max(high, fit.lift + kCoarse);
    }
  constexpr int kFine = 24;
  std::vector<Lifted> fine = grid(low, high, (high - low) / kFine);
  if (fine.empty()) return Miss::outside_model;
  return fine;
}

// Of ln of the speed, by lamps unlike the law. Where they are so by much, the fit trades what it
// does not know of the law for what it does of the motion, and no share of that can be stated.
Outcome<double> beam_log_variance(const PowerSeries& series, const PowerCase& known,
                                  const Lifted& best) {
  constexpr double kMostRipple_nat = 0.05;
  const auto start = paper_motion(series, known);
  const auto* motion = std::get_if<PassMotion>(&start);
  const auto ripple_nat = beam_ripple_nat(series, known, motion ? *motion : best.motion);
  if (!ripple_nat) return Miss::outside_model;
  if (*ripple_nat > kMostRipple_nat) return Miss::bad_fit;
  return beam_variance(series, known, best.motion, *ripple_nat, [&](const PowerSeries& unlike) {
    const auto pulled = fit_lifted(blocks_of(unlike), known, best.lift, series.background_std_w);
    const auto* lifted = std::get_if<Lifted>(&pulled);
    return lifted ? lifted->log_speed : INFINITY;
  });
}

}  // namespace

Outcome<PowerSpeed> ml_speed(const PowerSeries& series, const PowerCase& known) {
  constexpr double kWorstChi2 = 4.0;
  constexpr double kMostPriorChi2 = 16.0;  // of four priors: three passes in a thousand
  constexpr double kTwoSided95 = 1.959963984540054;
  const SeriesBlocks blocks = blocks_of(series);
  const auto outcome = fits_over_background(blocks, known, series.background_std_w);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) return *miss;
  const auto& fits = std::get<std::vector<Lifted>>(outcome);
  const Lifted& best = likeliest(fits);
  if (best.chi2_per_dof > kWorstChi2 || best.prior_chi2 > kMostPriorChi2) return Miss::bad_fit;
  const auto beam2 = beam_log_variance(series, known, best);
  if (const Miss* miss = std::get_if<Miss>(&beam2)) return *miss;
  double weights = 0.0, mean = 0.0, square = 0.0, range_m = 0.0;
  for (const Lifted& fit : fits) {
    const double weight = std::exp(-0.5 * (fit.chi2 - best.chi2));
    const double apart = fit.log_speed - best.log_speed;
    weights += weight;
    mean += weight * apart;
    square += weight * (apart * apart + fit.log_std * fit.log_std);
    range_m += weight * fit.range_m;
  }
  mean /= weights;
  PowerSpeed found;
  SpeedEstimate& speed = found.speed;
  speed.time_s = 0.5 * (blocks.time_s.front() + blocks.time_s.back());
  speed.speed_mps = std::exp(best.log_speed + mean);
  const double log_std = std::sqrt(square / weights - mean * mean + std::get<double>(beam2));
  if (!(log_std < kNoSpeedLogStd)) return Miss::too_uncertain;
  speed.std_mps = speed.speed_mps * log_std;
  speed.lo95_mps = speed.speed_mps * std::exp(-kTwoSided95 * log_std);
  speed.hi95_mps = speed.speed_mps * std::exp(kTwoSided95 * log_std);
  speed.samples_used = static_cast<std::int64_t>(series.time_s.size());
  const double along_m = range_m / weights + known.receiver_m.x();
  found.range_m =
      path_point(along_m, known.lateral_m.mean, known.bend, known.straight_m, known.radius_m.mean)
          .x_m;
  return found;
}

}  // namespace vildar
