#include "simulate/pass.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/random.h"
#include "estimate/curved_angle.h"
#include "estimate/power_bound.h"
#include "estimate/power_estimators.h"
#include "estimate/sliding_slope.h"
#include "optics/incidence.h"
#include "simulate/monte_carlo.h"

namespace vildar::simulate {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

double clean_power_w(const Pass& pass, double along_m) {
  if (!pass.curved) return pass.generator.power_w(along_m, pass.perpendicular_m);
  const PaperPlace place =
      curved_place({pass.radius_m, 0.0, 0.0}, Radians(along_m / pass.radius_m));
  return pass.generator.power_w(place.range_m, place.perpendicular_m);
}

double incidence_deg(const Pass& pass, double along_m) {
  if (!pass.curved)
    return degrees_from_radians(
        straight_place(Metres(along_m), Metres(pass.perpendicular_m)).incidence_rad);
  return degrees_from_radians(
      curved_place({pass.radius_m, 0.0, 0.0}, Radians(along_m / pass.radius_m)).incidence_rad);
}

// The paper's speed for every window, by sums that slide.
std::vector<double> paper_speeds(const Pass& pass, const std::vector<double>& power_w,
                                 std::size_t window) {
  const std::size_t windows = power_w.size() - window + 1;
  std::vector<double> speeds(windows, kNone);
  if (!pass.curved) {
    SlidingPowerSlope slope(pass.generator, Metres(pass.perpendicular_m), window);
    for (std::size_t i = 0; i < power_w.size(); ++i) {
      slope.push(static_cast<double>(i) * pass.sample_period_s, power_w[i]);
      if (i + 1 >= window)
        if (const auto speed = slope.speed_mps()) speeds[i + 1 - window] = *speed;
    }
    return speeds;
  }
  PowerLaw law = pass.generator;
  law.cosine_exponent = pass.cosine_known;
  std::vector<double> along_m(power_w.size());
  for (std::size_t i = 0; i < power_w.size(); ++i)
    along_m[i] = pass.radius_m * arc_angle_of_power(power_w[i], law, Metres(pass.radius_m));
  // Uniform times: slope = sum (i - middle) y / [dt sum (i - middle)^2], both sums sliding.
  const auto n = static_cast<double>(window);
  const double middle = 0.5 * (n - 1.0), spread = n * (n * n - 1.0) / 12.0;
  double sum = 0.0, moment = 0.0;
  for (std::size_t i = 0; i < window; ++i) {
    sum += along_m[i];
    moment += (static_cast<double>(i) - middle) * along_m[i];
  }
  for (std::size_t from = 0;; ++from) {
    speeds[from] = -moment / (spread * pass.sample_period_s);
    if (from + 1 == windows) break;
    const double out = along_m[from], in = along_m[from + window];
    moment += middle * out - (sum - out) + middle * in;
    sum += in - out;
  }
  return speeds;
}

PowerProblem ml_problem(const Pass& pass) {
  PowerProblem problem;
  problem.setting.cosine_exponent = pass.generator.cosine_exponent;
  problem.setting.curved = pass.curved;
  problem.known[kPowerLogGain] = Uncertain{std::log(pass.generator.gain_w), 0.0};
  problem.known[kPowerExponent] = Uncertain{pass.generator.path_loss_exponent, 0.0};
  problem.known[kPowerPerpendicular] = Uncertain{pass.curved ? 0.0 : pass.perpendicular_m, 0.0};
  problem.known[kPowerRadius] = Uncertain{pass.radius_m, 0.0};
  return problem;
}

// Sum of absolute errors, errors and squared errors over the trials, at one place.
struct Sums {
  double absolute = 0.0, error = 0.0, square = 0.0;
  int count = 0;

  void add(double error_mps) {
    if (!std::isfinite(error_mps)) return;
    absolute += std::abs(error_mps);
    error += error_mps;
    square += error_mps * error_mps;
    ++count;
  }
  double accuracy(double speed) const {
    return count > 0 ? 100.0 * (1.0 - absolute / count / speed) : kNone;
  }
  double rmse(double speed) const {
    return count > 0 ? 100.0 * std::sqrt(square / count) / speed : kNone;
  }
};

}  // namespace

double power_at_start_w(const Pass& pass) { return clean_power_w(pass, pass.start_m); }

double sigma_of(double snr_db, SnrKind kind, double power_w) {
  return power_w * std::pow(10.0, -snr_db / (kind == SnrKind::electrical ? 20.0 : 10.0));
}

Pass straight_pass(const Options& options, bool cosine) {
  Pass pass;
  pass.generator = {ratio_from_db(options.gain_db), options.path_loss_exponent,
                    cosine ? options.cosine_exponent() : 0.0};
  pass.speed_mps = options.speed_mps;
  pass.start_m = options.start_range_m;
  pass.perpendicular_m = options.perpendicular_m;
  pass.sample_period_s = options.sample_period_s;
  pass.duration_s = options.duration_s;
  pass.sigma_w = sigma_of(options.snr_db, options.snr_kind, power_at_start_w(pass));
  return pass;
}

Pass curved_pass(const Options& options, bool cosine) {
  Pass pass = straight_pass(options, cosine);
  pass.curved = true;
  pass.cosine_known = pass.generator.cosine_exponent;
  pass.radius_m = options.curve_radius_m;
  pass.speed_mps = options.angular_speed_rad_per_s * options.curve_radius_m;
  pass.start_m = radians_from_degrees(options.curve_start_deg) * options.curve_radius_m;
  pass.duration_s = options.curve_duration_s;
  pass.sigma_w = sigma_of(options.snr_db, options.snr_kind, power_at_start_w(pass));
  return pass;
}

PassScores score_pass(const Pass& pass, const Options& options, std::uint64_t stream,
                      bool first_window_only) {
  constexpr std::size_t kMlPlaces = 24;
  const auto window = static_cast<std::size_t>(std::lround(pass.duration_s / pass.sample_period_s));
  std::vector<double> time_s, clean_w;
  for (std::size_t i = 0; first_window_only ? i < window : true; ++i) {
    const double t_s = static_cast<double>(i) * pass.sample_period_s;
    const double along_m = pass.start_m - pass.speed_mps * t_s;
    if (!(along_m > 1e-9 * pass.start_m)) break;
    time_s.push_back(t_s);
    clean_w.push_back(clean_power_w(pass, along_m));
  }
  PassScores scores;
  if (time_s.size() < window) return scores;
  const std::size_t windows = time_s.size() - window + 1;
  std::vector<std::size_t> ml_at;
  if (options.maximum_likelihood)
    for (std::size_t k = 0; k < std::min(kMlPlaces, windows); ++k)
      ml_at.push_back(windows == 1 ? 0 : k * (windows - 1) / (std::min(kMlPlaces, windows) - 1));

  const auto trials = static_cast<std::size_t>(options.trials);
  std::vector<float> errors(trials * windows), ml_errors(trials * ml_at.size());
  for_each_trial(options.trials, options.threads, [&](int trial) {
    Random random(trial_seed(options.seed, stream, trial));
    std::vector<double> power_w = clean_w;
    for (double& power : power_w) power += pass.sigma_w * random.normal();
    const std::vector<double> speeds = paper_speeds(pass, power_w, window);
    const auto row = static_cast<std::size_t>(trial);
    for (std::size_t i = 0; i < windows; ++i)
      errors[row * windows + i] = static_cast<float>(speeds[i] - pass.speed_mps);
    PowerProblem problem = ml_problem(pass);
    problem.sigma_w = std::span(&pass.sigma_w, 1);
    for (std::size_t k = 0; k < ml_at.size(); ++k) {
      problem.time_s = std::span(time_s).subspan(ml_at[k], window);
      problem.power_w = std::span(power_w).subspan(ml_at[k], window);
      const PowerOutcome outcome = estimate_power(problem, PowerMethod::max_likelihood);
      const auto* estimate = std::get_if<PowerEstimate>(&outcome);
      ml_errors[row * ml_at.size() + k] =
          static_cast<float>(estimate ? estimate->speed_mps() - pass.speed_mps : kNone);
    }
  });

  const double shift_s = options.label == WindowLabel::start    ? 0.0
                         : options.label == WindowLabel::centre ? 0.5
                                                                : 1.0;
  const double label_s = shift_s * static_cast<double>(window - 1) * pass.sample_period_s;
  for (std::size_t i = 0; i < windows; ++i) {
    Sums sums;
    for (std::size_t trial = 0; trial < trials; ++trial) sums.add(errors[trial * windows + i]);
    const double t_s = time_s[i] + label_s;
    const double along_m = pass.start_m - pass.speed_mps * t_s;
    scores.time_s.push_back(t_s);
    scores.along_m.push_back(along_m);
    scores.incidence_deg.push_back(incidence_deg(pass, along_m));
    scores.accuracy_percent.push_back(sums.accuracy(pass.speed_mps));
    scores.bias_percent.push_back(100.0 * sums.error / std::max(1, sums.count) / pass.speed_mps);
    scores.rmse_percent.push_back(sums.rmse(pass.speed_mps));
    scores.missing.push_back(1.0 - static_cast<double>(sums.count) / options.trials);
  }
  PowerVector truth = PowerVector::Zero();
  const PowerProblem problem = ml_problem(pass);
  for (int p = 0; p < kPowerParameters; ++p)
    if (problem.known[p]) truth[p] = problem.known[p]->mean;
  truth[kPowerSpeed] = pass.speed_mps;
  truth[kPowerRange] = pass.start_m;
  for (std::size_t k = 0; k < ml_at.size(); ++k) {
    Sums sums;
    for (std::size_t trial = 0; trial < trials; ++trial)
      sums.add(ml_errors[trial * ml_at.size() + k]);
    scores.ml_time_s.push_back(scores.time_s[ml_at[k]]);
    scores.ml_incidence_deg.push_back(scores.incidence_deg[ml_at[k]]);
    scores.ml_accuracy_percent.push_back(sums.accuracy(pass.speed_mps));
    scores.ml_rmse_percent.push_back(sums.rmse(pass.speed_mps));
    const auto bound = power_bound(std::span(time_s).subspan(ml_at[k], window), pass.sigma_w, truth,
                                   problem.known, problem.setting);
    const auto* matrix = std::get_if<PowerMatrix>(&bound);
    scores.bound_percent.push_back(
        matrix ? 100.0 * std::sqrt((*matrix)(kPowerSpeed, kPowerSpeed)) / pass.speed_mps : kNone);
  }
  return scores;
}

double last_above(const std::vector<double>& x, const std::vector<double>& accuracy, double level) {
  if (x.empty()) return kNone;
  std::size_t last = 0;
  while (last + 1 < x.size() && accuracy[last] >= level && accuracy[last + 1] >= level) ++last;
  return x[last];
}

}  // namespace vildar::simulate
