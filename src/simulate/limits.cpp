#include <array>
#include <cmath>

#include "core/random.h"
#include "estimate/power_bound.h"
#include "estimate/power_estimators.h"
#include "simulate/experiments.h"
#include "simulate/monte_carlo.h"
#include "simulate/pass.h"
#include "simulate/series.h"

namespace vildar::simulate {
namespace {

struct Window {
  std::vector<double> time_s, clean_w;
  PowerVector truth = PowerVector::Zero();
  PowerProblem problem;  ///< K, d, gamma known; its spans are the caller's to set
  double sigma_w = 0.0;
};

// Samples from `from_m` to `to_m`, noise relative to the power at the start of the pass without the
// cosine, so that the windows share one noise.
Window window_of(const Options& options, bool cosine, double from_m, double to_m, double snr_db) {
  const Pass pass = straight_pass(options, cosine);
  Window window;
  window.sigma_w =
      sigma_of(snr_db, options.snr_kind, power_at_start_w(straight_pass(options, false)));
  const auto count = std::lround((from_m - to_m) / options.speed_mps / options.sample_period_s);
  for (long i = 0; i < count; ++i) {
    const double t_s = static_cast<double>(i) * options.sample_period_s;
    window.time_s.push_back(t_s);
    window.clean_w.push_back(
        pass.generator.power_w(from_m - options.speed_mps * t_s, options.perpendicular_m));
  }
  window.truth[kPowerSpeed] = options.speed_mps;
  window.truth[kPowerRange] = from_m;
  window.truth[kPowerLogGain] = std::log(pass.generator.gain_w);
  window.truth[kPowerPerpendicular] = options.perpendicular_m;
  window.truth[kPowerExponent] = options.path_loss_exponent;
  window.problem.setting.cosine_exponent = pass.generator.cosine_exponent;
  for (const PowerParameter p : {kPowerLogGain, kPowerPerpendicular, kPowerExponent})
    window.problem.known[p] = Uncertain{window.truth[p], 0.0};
  return window;
}

// The windows of the pass as shares of its length: far, middle, near, all.
constexpr std::array<std::pair<double, double>, 4> kWindows{
    {{1.0, 0.6}, {0.7, 0.3}, {6.5 / 15.0, 0.5 / 15.0}, {1.0, 0.04}}};

std::string words(double from_m, double to_m) {
  return fixed_text(from_m, 1) + " to " + fixed_text(to_m, 1) + " m";
}

std::string percent(const std::variant<PowerMatrix, PowerRefusal>& bound, double speed_mps) {
  const auto* matrix = std::get_if<PowerMatrix>(&bound);
  if (matrix == nullptr) return "not observable";
  const double value = 100.0 * std::sqrt((*matrix)(kPowerSpeed, kPowerSpeed)) / speed_mps;
  return value < 1e4 ? fixed_text(value, value < 1.0 ? 4 : 2) : "above 10000";
}

}  // namespace

Report bounds(const Options& options) {
  Report report{"bounds", {}, {}, {}};
  struct Set {
    const char* name;
    std::vector<PowerParameter> unknown;
  };
  const std::vector<Set> sets{{"V, R", {}},
                              {"+ K", {kPowerLogGain}},
                              {"+ d", {kPowerPerpendicular}},
                              {"+ gamma", {kPowerExponent}},
                              {"+ a", {kPowerAcceleration}},
                              {"+ d, a", {kPowerPerpendicular, kPowerAcceleration}},
                              {"+ K, gamma", {kPowerLogGain, kPowerExponent}},
                              {"+ K, d", {kPowerLogGain, kPowerPerpendicular}}};
  for (const bool cosine : cosine_readings(options)) {
    Table table{"bounds-" + cosine_tag(cosine),
                "Cramer-Rao bound of the speed, % of it, " + cosine_title(cosine),
                "One standard deviation at the start of the window, initial SNR 40 dB; for another "
                "SNR multiply by 10^((40 - SNR) / 20). Known: everything not named.",
                {"window"},
                {}};
    for (const Set& set : sets) table.header.emplace_back(set.name);
    for (const auto& [from, to] : kWindows) {
      const double from_m = from * options.start_range_m, to_m = to * options.start_range_m;
      const Window window = window_of(options, cosine, from_m, to_m, 40.0);
      std::vector<std::string> row{words(from_m, to_m)};
      for (const Set& set : sets) {
        PowerKnowledge known = window.problem.known;
        for (const PowerParameter p : set.unknown) known[p].reset();
        row.push_back(percent(
            power_bound(window.time_s, window.sigma_w, window.truth, known, window.problem.setting),
            options.speed_mps));
      }
      table.rows.push_back(row);
    }
    report.tables.push_back(table);
  }
  return report;
}

Report efficiency(const Options& options) {
  Report report{"efficiency", {}, {}, {}};
  static constexpr std::array kMethods{PowerMethod::paper_ls, PowerMethod::weighted_ls,
                                       PowerMethod::max_likelihood, PowerMethod::huber,
                                       PowerMethod::kalman};
  std::uint64_t stream = 20000;
  for (const bool cosine : cosine_readings(options)) {
    Table table{"efficiency-" + cosine_tag(cosine),
                "Error over the bound, and coverage of the 95 % interval, " + cosine_title(cosine),
                "Root mean square error of the speed over the Cramer-Rao bound, K, d and gamma "
                "known; share of trials in which the 95 % interval holds the truth; share without "
                "an estimate.",
                {"window", "snr_db", "method", "rmse_over_bound", "coverage_95", "refused"},
                {}};
    for (const auto& [from, to] : kWindows)
      for (const double snr_db : options.snrs_db) {
        const double from_m = from * options.start_range_m, to_m = to * options.start_range_m;
        const Window window = window_of(options, cosine, from_m, to_m, snr_db);
        const auto bound =
            std::get<PowerMatrix>(power_bound(window.time_s, window.sigma_w, window.truth,
                                              window.problem.known, window.problem.setting));
        struct Trial {
          std::array<double, kMethods.size()> error{};
          std::array<bool, kMethods.size()> given{}, covered{};
        };
        std::vector<Trial> trials(static_cast<std::size_t>(options.trials));
        ++stream;
        for_each_trial(options.trials, options.threads, [&](int index) {
          Random random(trial_seed(options.seed, stream, index));
          std::vector<double> power_w = window.clean_w;
          for (double& power : power_w) power += window.sigma_w * random.normal();
          PowerProblem problem = window.problem;
          problem.time_s = window.time_s;
          problem.power_w = power_w;
          problem.sigma_w = std::span(&window.sigma_w, 1);
          Trial& trial = trials[static_cast<std::size_t>(index)];
          for (std::size_t k = 0; k < kMethods.size(); ++k) {
            const PowerOutcome outcome = estimate_power(problem, kMethods[k]);
            const auto* estimate = std::get_if<PowerEstimate>(&outcome);
            trial.given[k] = estimate != nullptr;
            if (estimate == nullptr) continue;
            trial.error[k] = estimate->speed_mps() - options.speed_mps;
            const auto interval = estimate->speed_95_mps();
            trial.covered[k] = interval[0] < options.speed_mps && options.speed_mps < interval[1];
          }
        });
        for (std::size_t k = 0; k < kMethods.size(); ++k) {
          double square = 0.0;
          int given = 0, covered = 0;
          for (const Trial& trial : trials) {
            if (!trial.given[k]) continue;
            ++given;
            covered += trial.covered[k];
            square += trial.error[k] * trial.error[k];
          }
          const double ratio =
              given > 0 ? std::sqrt(square / given / bound(kPowerSpeed, kPowerSpeed)) : 0.0;
          table.rows.push_back(
              {words(from_m, to_m), number_text(snr_db), std::string(name_of(kMethods[k])),
               given > 0 ? fixed_text(ratio, 3) : "",
               given > 0 ? fixed_text(static_cast<double>(covered) / given, 3) : "",
               fixed_text(1.0 - static_cast<double>(given) / options.trials, 3)});
        }
      }
    report.tables.push_back(table);
  }
  return report;
}

}  // namespace vildar::simulate
