#include "estimate/pass_posterior.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>

#include "estimate/pass_light.h"
#include "estimate/power_estimators.h"

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
    problem.setting.straight_m = known.straight_m.mean;
    problem.setting.height_m = std::abs(below_m);
    const double side = known.bend > 0.0 ? 1.0 : -1.0;
    problem.known[kPowerPerpendicular] = Uncertain{side * across_m, known.lateral_m.std};
    problem.known[kPowerRadius] = Uncertain{known.lane_radius_m(), known.radius_m.std};
  }
  return problem;
}

// Where the posterior's search begins: what the paper's estimator makes of the light, else the
// likeliest motion under the law.
std::optional<PassMotion> first_motion(const PowerSeries& series, const PowerCase& known) {
  const auto paper = paper_motion(series, known);
  if (const auto* motion = std::get_if<PassMotion>(&paper)) return *motion;
  const SeriesBlocks blocks = blocks_of(series);
  const auto outcome = estimate_max_likelihood(problem_of(blocks, known));
  if (std::holds_alternative<PowerRefusal>(outcome)) return std::nullopt;
  const auto& estimate = std::get<PowerEstimate>(outcome);
  if (!(estimate.speed_mps() > 0.0)) return std::nullopt;
  return PassMotion{estimate.reference_s, estimate.speed_mps(),
                    estimate.value[kPowerRange] + known.receiver_m.x(),
                    estimate.value[kPowerAcceleration]};
}

constexpr std::size_t kFewestSamples = 5;

struct Background {
  double sigmas = 0.0;
  bool for_all = true;  // whatever lamps may be unlike the law by, else the least first
};

// Where the background is unsure the light can be explained in more ways than one.
std::vector<Background> backgrounds(const PowerSeries& series) {
  constexpr double kHarmless = 0.002;  // of the least light
  if (!(series.background_std_w > kHarmless * least_mean_w(series))) return {{}};
  constexpr double kStep = 0.25;  // sigmas
  constexpr int kFarthest = 6, kForAll = 3;
  std::vector<Background> found;
  for (int k = -kFarthest; k <= kFarthest; ++k) found.push_back({kStep * k, k % kForAll == 0});
  return found;
}

// Lamps that differ in gain differ in shape, too: where the site says how far K may be off, none is
// nearer to the law than 0.15 of that. A K that was fitted to the light says nothing of lamps.
double least_ripple_nat(const PowerCase& known) {
  constexpr double kOfGain = 0.15;
  return known.log_gain_per_exponent ? 0.0 : kOfGain * known.log_gain_std;
}

// What the paper's estimator makes of the light above such a background; else `start`.
PassMotion motion_above(double background_w, const PowerSeries& series, const PowerCase& known,
                        const PassMotion& start) {
  if (background_w == 0.0) return start;
  PowerSeries above = series;
  for (double& power_w : above.power_w) power_w -= background_w;
  const auto outcome = paper_motion(above, known);
  const auto* motion = std::get_if<PassMotion>(&outcome);
  return motion ? *motion : start;
}

// One way to explain the light, about its likeliest unknowns.
struct Way {
  double evidence = 0.0;  // ln
  bool unlike_the_law = false;
  double ripple_nat = 0.0;
  PassMotion motion;
  double log_speed_variance = 0.0;
  double background_w = 0.0, background_variance_w2 = 0.0;
  double chi2_per_dof = 0.0, prior_chi2 = 0.0;
};

std::optional<Way> way_at(const PassLight& light, const Minimum& minimum, double ripple_nat,
                          double background_std_w) {
  const Eigen::LLT<Eigen::MatrixXd> root(minimum.information);
  if (root.info() != Eigen::Success) return std::nullopt;
  const Eigen::VectorXd& z = minimum.unknowns;
  const Eigen::MatrixXd covariance =
      root.solve(Eigen::MatrixXd::Identity(kPassUnknowns, kPassUnknowns));
  Way way;
  way.ripple_nat = ripple_nat;
  way.evidence = -minimum.cost - root.matrixLLT().diagonal().array().log().sum();
  way.motion = light.motion_of(z);
  // Two unknowns have no prior.
  way.chi2_per_dof = 2.0 * minimum.cost / std::max(1.0, static_cast<double>(light.blocks()) - 2.0);
  way.prior_chi2 = z.segment(kSpeedingUp, kShape - kSpeedingUp).squaredNorm();
  const double scatter = std::max(1.0, way.chi2_per_dof);
  way.log_speed_variance = scatter * covariance(kLogSpeed, kLogSpeed);
  way.background_w = z[kDark] * background_std_w;
  way.background_variance_w2 =
      scatter * covariance(kDark, kDark) * background_std_w * background_std_w;
  return way;
}

// Descents from different backgrounds may end in one place.
bool same(const Way& one, const Way& other) {
  constexpr double kNear2 = 0.2 * 0.2;  // of a variance
  const double apart = std::log(one.motion.speed_mps / other.motion.speed_mps);
  const double lifted_w = one.background_w - other.background_w;
  return one.ripple_nat == other.ripple_nat && apart * apart <= kNear2 * one.log_speed_variance &&
         lifted_w * lifted_w <= kNear2 * one.background_variance_w2;
}

enum class Descent { nowhere, to_known_way, to_new_way };

PassPosterior mean_of(const std::vector<Way>& ways) {
  const Way& best =
      *std::ranges::max_element(ways, {}, [](const Way& way) { return way.evidence; });
  double sum = 0.0, ripple2 = 0.0, log_speed = 0.0, log_speed2 = 0.0, along_m = 0.0;
  double speeding_up = 0.0, background = 0.0, background2 = 0.0, unlike_the_law = 0.0;
  for (const Way& way : ways) {
    const double weight = std::exp(way.evidence - best.evidence);
    const double apart = std::log(way.motion.speed_mps / best.motion.speed_mps);
    const double lifted_w = way.background_w - best.background_w;
    sum += weight;
    if (way.unlike_the_law) unlike_the_law += weight;
    ripple2 += weight * way.ripple_nat * way.ripple_nat;
    log_speed += weight * apart;
    log_speed2 += weight * (apart * apart + way.log_speed_variance);
    along_m += weight * way.motion.along_m;
    speeding_up += weight * way.motion.acceleration_mps2;
    background += weight * lifted_w;
    background2 += weight * (lifted_w * lifted_w + way.background_variance_w2);
  }
  log_speed /= sum;
  background /= sum;
  PassPosterior found;
  found.motion = {best.motion.reference_s, best.motion.speed_mps * std::exp(log_speed),
                  along_m / sum, speeding_up / sum};
  found.log_speed_std = std::sqrt(log_speed2 / sum - log_speed * log_speed);
  found.ripple_nat = std::sqrt(ripple2 / sum);
  found.background_w = best.background_w + background;
  found.background_std_w = std::sqrt(background2 / sum - background * background);
  found.unlike_the_law = unlike_the_law > 0.5 * sum;
  found.chi2_per_dof = best.chi2_per_dof;
  found.prior_chi2 = best.prior_chi2;
  return found;
}

}  // namespace

Outcome<PassPosterior> pass_posterior(const PowerSeries& series, const PowerCase& known,
                                      const PassMotion& start) {
  // Small ones are likelier beforehand, by their inverse root: the site states a law.
  constexpr std::array<double, 6> kRipples_nat{1.0, 0.5, 0.25, 0.1, 0.03, 0.01};
  constexpr double kOfTheLaw_nat = 0.05;
  constexpr std::size_t kFewestBlocks = 5;
  if (series.time_s.size() < kFewestSamples) return Miss::outside_model;
  constexpr double kTolerance = 0.02;
  constexpr double kHopelessChi2 = 25.0;  // of a block
  std::vector<Way> ways;
  bool hopeless = false;
  for (const auto& [background, for_all] : backgrounds(series)) {
    PassMotion from = motion_above(background * series.background_std_w, series, known, start);
    // All ways tell the speed of one time.
    from.along_m -= (start.reference_s - from.reference_s) * from.speed_mps;
    from.reference_s = start.reference_s;
    const PassLight light(series, known, from);
    if (light.blocks() < kFewestBlocks) return Miss::outside_model;
    Eigen::VectorXd nearest = light.nearest_to(from);
    nearest[kDark] = background;
    // Moves z to the minimum near by, if there is one.
    const auto adds_way = [&](double more_nat, Eigen::VectorXd& z) {
      const double ripple_nat = std::hypot(more_nat, least_ripple_nat(known));
      const auto outcome =
          descend([&](const Eigen::VectorXd& at,
                      bool with_slopes) { return light.residuals(at, ripple_nat, with_slopes); },
                  z, kTolerance,
                  {.hopeless_cost = 0.5 * kHopelessChi2 * static_cast<double>(light.blocks())});
      const auto* minimum = std::get_if<Minimum>(&outcome);
      if (!minimum) {
        hopeless |= std::get<Miss>(outcome) == Miss::bad_fit;
        return Descent::nowhere;
      }
      auto way = way_at(light, *minimum, ripple_nat, series.background_std_w);
      if (!way) return Descent::nowhere;
      way->evidence -= 0.5 * std::log(more_nat);
      way->unlike_the_law = more_nat > kOfTheLaw_nat;
      z = minimum->unknowns;
      if (std::ranges::any_of(ways, [&](const Way& known_way) { return same(*way, known_way); }))
        return Descent::to_known_way;
      ways.push_back(*way);
      return Descent::to_new_way;
    };
    Eigen::VectorXd z = nearest;
    // From a known way on all others would be known, too.
    if (for_all)
      for (const double more_nat : kRipples_nat)
        if (adds_way(more_nat, z) == Descent::to_known_way) break;
    // What may be unlike the law by much wanders far from where it began; what may not finds the
    // nearest, and where that is another all begin there.
    z = nearest;
    for (auto more_nat = kRipples_nat.rbegin(); more_nat != kRipples_nat.rend(); ++more_nat)
      if (adds_way(*more_nat, z) != Descent::to_new_way) break;
  }
  if (ways.empty()) return hopeless ? Miss::bad_fit : Miss::outside_model;
  return mean_of(ways);
}

Outcome<PassPosterior> pass_posterior(const PowerSeries& series, const PowerCase& known) {
  if (series.time_s.size() < kFewestSamples) return Miss::outside_model;
  const auto start = first_motion(series, known);
  if (!start) return Miss::outside_model;
  return pass_posterior(series, known, *start);
}

}  // namespace vildar
