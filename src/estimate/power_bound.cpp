#include "estimate/power_bound.h"

#include <stdexcept>

namespace vildar {

std::variant<PowerMatrix, PowerRefusal> power_bound(std::span<const double> time_s, double sigma_w,
                                                    const PowerVector& truth,
                                                    const PowerKnowledge& known,
                                                    const PowerSetting& setting) {
  const std::vector<double> sigmas(time_s.size(), sigma_w);
  return power_bound(time_s, std::span(sigmas), truth, known, setting);
}

std::variant<PowerMatrix, PowerRefusal> power_bound(std::span<const double> time_s,
                                                    std::span<const double> sigma_w,
                                                    const PowerVector& truth,
                                                    const PowerKnowledge& known,
                                                    const PowerSetting& setting) {
  if (sigma_w.size() != time_s.size())
    throw std::invalid_argument("power_bound: as many sigmas as times are needed");
  for (const double sigma : sigma_w)
    if (!(sigma > 0.0)) throw std::domain_error("power_bound: sigma must be positive");
  if (auto refusal = scale_missing(known, setting)) return *refusal;
  const std::vector<PowerParameter> free = free_parameters(known, setting);
  PowerCurve curve;
  curve.differentiate(truth, setting, time_s, free);
  const auto n = static_cast<Eigen::Index>(free.size());
  const auto samples = static_cast<Eigen::Index>(time_s.size());
  const Eigen::Map<const Eigen::ArrayXd> sigma(sigma_w.data(), samples);
  Eigen::MatrixXd jacobian(samples, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::span<const double> column = curve.column(static_cast<std::size_t>(i));
    jacobian.col(i) = Eigen::Map<const Eigen::ArrayXd>(column.data(), samples) / sigma;
  }
  Eigen::MatrixXd information = jacobian.transpose() * jacobian;
  for (Eigen::Index i = 0; i < n; ++i)
    if (const auto& prior = known[free[static_cast<std::size_t>(i)]])
      information(i, i) += 1.0 / (prior->std * prior->std);
  auto inverse = invert_information(information, free);
  if (auto* refusal = std::get_if<PowerRefusal>(&inverse)) return *refusal;
  return spread_covariance(std::get<Eigen::MatrixXd>(inverse), free);
}

}  // namespace vildar
