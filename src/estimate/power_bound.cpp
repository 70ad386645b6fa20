#include "estimate/power_bound.h"

#include <stdexcept>

namespace vildar {

std::variant<PowerMatrix, PowerRefusal> power_bound(std::span<const double> time_s, double sigma_w,
                                                    const PowerVector& truth,
                                                    const PowerKnowledge& known,
                                                    const PowerSetting& setting) {
  if (!(sigma_w > 0.0)) throw std::domain_error("power_bound: sigma must be positive");
  if (auto refusal = scale_missing(known, setting)) return *refusal;
  const std::vector<PowerParameter> free = free_parameters(known, setting);
  PowerCurve curve;
  curve.differentiate(truth, setting, time_s, free);
  const auto n = static_cast<Eigen::Index>(free.size());
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
  const auto samples = static_cast<Eigen::Index>(time_s.size());
  const auto column = [&](Eigen::Index i) {
    return Eigen::Map<const Eigen::VectorXd>(curve.column(static_cast<std::size_t>(i)).data(),
                                             samples);
  };
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j)
      information(i, j) = information(j, i) = column(i).dot(column(j)) / (sigma_w * sigma_w);
  for (Eigen::Index i = 0; i < n; ++i)
    if (const auto& prior = known[free[static_cast<std::size_t>(i)]])
      information(i, i) += 1.0 / (prior->std * prior->std);
  auto inverse = invert_information(information, free);
  if (auto* refusal = std::get_if<PowerRefusal>(&inverse)) return *refusal;
  return spread_covariance(std::get<Eigen::MatrixXd>(inverse), free);
}

}  // namespace vildar
