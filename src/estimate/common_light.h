#pragma once

#include <optional>

#include "estimate/delay_model.h"

namespace vildar {

/// Where a model is near its optimum.
struct LightFit {
  Eigen::VectorXd value;
  bool moves = true;            ///< whether the delay is free
  double step_precision = 0.0;  ///< of the prior on a step of the acceleration
  double noise_factor = 1.0;    ///< as in DelayMotion
  Uncertain log_ratio;          ///< what the model holds of the gain
};

/// By how much chi-square would fall, in units of the noise.
struct FoundLight {
  CommonLight light;
  double chi2 = 0.0;
};

/// What explains most of a fit's residuals as light that both photodiodes receive at once, of 5 to
/// 70 ms, if it does so far beyond noise and beyond what unlike gains and angles could, and is
/// about as bright to both.
std::optional<FoundLight> find_common_light(const DelayModel& model, const DelayRows& rows,
                                            const LightFit& fit);

}  // namespace vildar
