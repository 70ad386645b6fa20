#pragma once

#include <vector>

#include "optics/channel.h"
#include "simulate/options.h"

namespace vildar::simulate {

/// One pass of a vehicle and the window that slides over it.
struct Pass {
  PowerLaw generator;         ///< gives the samples
  double cosine_known = 0.0;  ///< m that the paper's estimator takes: 0 on straight roads
  bool curved = false;
  double speed_mps = 20.0;
  double start_m = 15.0;  ///< R_o, or r_c beta_o on a curve
  double perpendicular_m = 0.5;
  double radius_m = 40.0;
  double sample_period_s = 1e-3;
  double duration_s = 0.3;
  double sigma_w = 0.0;
};
Pass straight_pass(const Options& options, bool cosine);
/// R_o = d_o = 0, as the paper has it; the estimator knows the cosine where the generator has it.
Pass curved_pass(const Options& options, bool cosine);
/// Noise of a sample for a power at the start of the pass.
double sigma_of(double snr_db, SnrKind kind, double power_at_start_w);
double power_at_start_w(const Pass& pass);

/// Estimates of every window of a pass, averaged over the trials.
struct PassScores {
  // One entry per place of the window.
  std::vector<double> time_s;                                        ///< of the label
  std::vector<double> along_m;                                       ///< of the label
  std::vector<double> incidence_deg;                                 ///< of the label
  std::vector<double> accuracy_percent, bias_percent, rmse_percent;  ///< the paper's estimator
  std::vector<double> missing;                                       ///< share without an estimate
  /// Of maximum likelihood with the full model, and the Cramer-Rao bound; at fewer places.
  std::vector<double> ml_time_s, ml_incidence_deg, ml_accuracy_percent, ml_rmse_percent,
      bound_percent;
};
/// `stream` separates the random numbers of different series. `first_window_only` stops there.
PassScores score_pass(const Pass& pass, const Options& options, std::uint64_t stream,
                      bool first_window_only = false);

/// The last x before `accuracy` first falls below `level`; the first x where it starts below.
double last_above(const std::vector<double>& x, const std::vector<double>& accuracy, double level);

}  // namespace vildar::simulate
