#pragma once

#include <string_view>

#include "estimate/power_problem.h"

namespace vildar {

enum class PowerMethod {
  paper_ls,        ///< the paper's linear least squares: V and R alone, the rest known exactly
  weighted_ls,     ///< the same line with the weights that the transform of the noise asks for
  max_likelihood,  ///< least squares on P(t) itself, any unknowns; with priors the posterior mode
  huber,           ///< max_likelihood with Huber's loss at 1.345 sigma: 95 % efficient, robust
  ceres,           ///< max_likelihood by Ceres with automatic derivatives: slow, independent
  kalman,          ///< extended Kalman filter, sample by sample
};
std::string_view name_of(PowerMethod method);

/// Speed from power by one method. Refuses, with the reason in words, what the samples do not
/// determine. Throws as gather() does.
PowerOutcome estimate_power(const PowerProblem& problem, PowerMethod method);

// Each method by itself; estimate_power() chooses among them.
PowerOutcome estimate_paper_ls(const PowerProblem& problem);
PowerOutcome estimate_weighted_ls(const PowerProblem& problem);
PowerOutcome estimate_max_likelihood(const PowerProblem& problem);
PowerOutcome estimate_huber(const PowerProblem& problem);
PowerOutcome estimate_ceres(const PowerProblem& problem);
PowerOutcome estimate_kalman(const PowerProblem& problem);

/// Speed of a vehicle on a straight road from one photodiode's samples: the ready-made form of
/// max_likelihood. `gain` is K in watts at 1 m with its std; a std of zero means known, an absent
/// value unknown. Without `acceleration_mps2` the speed is constant.
struct PhotodiodeKnowledge {
  std::optional<Uncertain> perpendicular_m;
  std::optional<Uncertain> gain_w;
  std::optional<Uncertain> path_loss_exponent;
  std::optional<Uncertain> acceleration_mps2;
  double cosine_exponent = 0.0;
};
PowerOutcome estimate_photodiode(std::span<const double> time_s, std::span<const double> power_w,
                                 std::span<const double> sigma_w, double reference_s,
                                 const PhotodiodeKnowledge& knowledge);

}  // namespace vildar
