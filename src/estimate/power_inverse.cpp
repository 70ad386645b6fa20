#include "estimate/power_inverse.h"

#include <algorithm>
#include <cmath>

#include "core/quantity.h"
#include "estimate/vector_math.h"

namespace vildar {
namespace {

// A vehicle that stands at `along` at time `along`, so that a curve over time is one over the path.
PowerVector standing_at_time(PowerVector parameters) {
  parameters[kPowerSpeed] = -1.0;
  parameters[kPowerRange] = 0.0;
  parameters[kPowerAcceleration] = 0.0;
  return parameters;
}

// Places from far to near, dense where the power changes fast.
std::vector<double> places(double least_w, double most_w, const PowerVector& p,
                           const PowerSetting& setting) {
  constexpr int kCount = 192;
  constexpr double kNearest = 2e-3;  // of the distance that the brightest implies on axis
  const auto on_axis_m = [&](double power_w) {
    return std::exp((p[kPowerLogGain] - std::log(power_w)) / p[kPowerExponent]);
  };
  const double farthest_m =
      setting.curved ? setting.straight_m + kPi * p[kPowerRadius] : 1.05 * on_axis_m(least_w);
  const double nearest_m = kNearest * on_axis_m(most_w);
  const double ratio =
      std::pow(std::min(0.5, nearest_m / farthest_m), 1.0 / static_cast<double>(kCount - 1));
  std::vector<double> along_m(kCount, farthest_m);
  for (std::size_t i = 1; i < along_m.size(); ++i) along_m[i] = ratio * along_m[i - 1];
  return along_m;
}

}  // namespace

ImpliedPath implied_path(std::span<const double> power_w, const PowerVector& parameters,
                         const PowerSetting& setting) {
  constexpr int kNewtonSteps = 6;
  const std::size_t n = power_w.size();
  ImpliedPath path{std::vector<double>(n), std::vector<double>(n), std::vector<char>(n, 0)};
  double least_w = 0.0, most_w = 0.0;
  for (const double power : power_w) {
    if (power > 0.0 && (least_w == 0.0 || power < least_w)) least_w = power;
    most_w = std::max(most_w, power);
  }
  if (least_w == 0.0) return path;

  const PowerVector standing = standing_at_time(parameters);
  const std::vector<double> along_m = places(least_w, most_w, parameters, setting);
  PowerCurve curve;
  curve.evaluate(standing, setting, along_m);
  // Table of the outer branch, powers rising, in logarithms.
  const std::span<const double> table = curve.power_w();
  std::size_t branch = 1;
  while (branch < table.size() && table[branch] > table[branch - 1]) ++branch;
  if (branch < 2) {
    std::fill(path.along_m.begin(), path.along_m.end(), along_m.front());
    return path;
  }
  std::vector<double> rising(table.begin(), table.begin() + static_cast<std::ptrdiff_t>(branch));
  std::vector<double> log_along(along_m.begin(),
                                along_m.begin() + static_cast<std::ptrdiff_t>(branch));
  const double least = rising.front(), most = rising.back();
  for (std::size_t i = 0; i < n; ++i) {
    path.inside[i] = power_w[i] >= least && power_w[i] <= most;
    path.along_m[i] = path.inside[i] ? power_w[i] : most;
  }
  for (auto* values : {&rising, &log_along, &path.along_m}) natural_logs(*values, *values);
  for (double& value : path.along_m) {
    const auto upper = std::upper_bound(rising.begin(), rising.end(), value);
    const auto right = std::clamp<std::ptrdiff_t>(upper - rising.begin(), 1,
                                                  static_cast<std::ptrdiff_t>(branch) - 1);
    const auto r = static_cast<std::size_t>(right);
    const double share = (value - rising[r - 1]) / (rising[r] - rising[r - 1]);
    value = std::lerp(log_along[r - 1], log_along[r], share);
  }
  exponentials(path.along_m, path.along_m);
  const PowerParameter wanted[] = {kPowerRange};
  for (int step = 0; step <= kNewtonSteps; ++step) {
    curve.differentiate(standing, setting, path.along_m, wanted);
    double largest = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const double slope = curve.column(0)[i];
      path.steepness[i] = std::abs(slope);
      if (!path.inside[i] || slope == 0.0) continue;
      const double relative = (power_w[i] - curve.power_w()[i]) / (slope * path.along_m[i]);
      if (step == kNewtonSteps || !(std::abs(relative) < 0.1)) continue;
      path.along_m[i] *= 1.0 + relative;
      largest = std::max(largest, std::abs(relative));
    }
    if (largest < 1e-9) break;
  }
  return path;
}

}  // namespace vildar
