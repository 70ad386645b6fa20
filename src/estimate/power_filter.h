#pragma once

#include "estimate/power_problem.h"

namespace vildar {

/// Extended Kalman filter over the parameters of a pass: a few microseconds per sample, for live
/// use. The state holds at the reference time of the times given; nothing is forgotten.
class PowerFilter {
 public:
  /// Parameters with zero variance in `covariance` stay as they are.
  PowerFilter(const PowerVector& value, const PowerMatrix& covariance, const PowerSetting& setting);

  /// One sample; sigma_w > 0. Samples that are not finite must not be given.
  void update(double time_s, double power_w, double sigma_w);

  const PowerVector& value() const { return value_; }
  const PowerMatrix& covariance() const { return covariance_; }
  /// Sum of squared whitened innovations: about one per sample where the model holds.
  double innovation_chi2() const { return innovation_chi2_; }

 private:
  PowerVector value_;
  PowerMatrix covariance_;
  PowerSetting setting_;
  std::vector<PowerParameter> free_;
  PowerCurve curve_;
  double innovation_chi2_ = 0.0;
};

}  // namespace vildar
