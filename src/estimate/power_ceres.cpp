#include <cmath>

#include <ceres/autodiff_cost_function.h>
#include <ceres/problem.h>

#include "estimate/power_estimators.h"
#include "estimate/power_start.h"
#include "estimate/solve.h"
#include "optics/road.h"

namespace vildar {
namespace {

// Whitened error of one sample, written out from the road's own geometry.
struct SampleResidual {
  double time_s, power_w, root_weight;
  PowerSetting setting;

  template <class T>
  bool operator()(const T* p, T* residual) const {
    using std::exp;
    using std::log;
    const T along_m =
        p[kPowerRange] - time_s * (p[kPowerSpeed] + 0.5 * time_s * p[kPowerAcceleration]);
    PathPoint<T> place{along_m, p[kPowerPerpendicular], T(0.0)};
    if (setting.curved) {
      if (!(p[kPowerRadius] > T(0.0))) return false;
      place = path_point(along_m, T(0.0), 1.0, setting.straight_m, p[kPowerRadius]);
      place.y_m += p[kPowerPerpendicular];
    }
    const T distance2 =
        place.x_m * place.x_m + place.y_m * place.y_m + setting.height_m * setting.height_m;
    if (!(distance2 > T(0.0))) return false;
    const double m = setting.cosine_exponent;
    T power(0.0);
    if (m == 0.0 || place.x_m > T(0.0)) {
      T log_power = p[kPowerLogGain] - 0.5 * (p[kPowerExponent] + m) * log(distance2);
      if (m > 0.0) log_power += m * log(place.x_m);
      power = exp(log_power);
    }
    residual[0] = root_weight * (power_w - power);
    return true;
  }
};

struct PriorOfOne {
  int index;
  Uncertain prior;

  template <class T>
  bool operator()(const T* p, T* residual) const {
    residual[0] = (p[index] - prior.mean) / prior.std;
    return true;
  }
};

}  // namespace

PowerOutcome estimate_ceres(const PowerProblem& problem) {
  auto gathered = gather(problem);
  if (auto* refusal = std::get_if<PowerRefusal>(&gathered)) return *refusal;
  const PowerSamples& samples = std::get<PowerSamples>(gathered);
  if (!samples.noise_known)
    return PowerRefusal{Miss::unobservable, "this method needs the noise of a sample"};
  auto start = power_start(samples, problem.known, problem.setting);
  if (auto* refusal = std::get_if<PowerRefusal>(&start)) return *refusal;
  PowerEstimate estimate;
  estimate.value = std::get<PowerVector>(start);

  const std::vector<PowerParameter> free = free_parameters(problem.known, problem.setting);
  ceres::Problem solver;
  double* block = estimate.value.data();
  for (std::size_t i = 0; i < samples.time_s.size(); ++i)
    solver.AddResidualBlock(
        new ceres::AutoDiffCostFunction<SampleResidual, 1, kPowerParameters>(new SampleResidual{
            samples.time_s[i], samples.power_w[i], std::sqrt(samples.weight[i]), problem.setting}),
        nullptr, block);
  double unknowns = 0.0;
  for (const PowerParameter p : free) {
    if (!problem.known[p]) {
      unknowns += 1.0;
      continue;
    }
    solver.AddResidualBlock(new ceres::AutoDiffCostFunction<PriorOfOne, 1, kPowerParameters>(
                                new PriorOfOne{p, *problem.known[p]}),
                            nullptr, block);
  }
  hold_fixed_all_but(std::vector<int>(free.begin(), free.end()), kPowerParameters, block, solver);
  const auto solved = solve(solver, {block});
  if (const Miss* miss = std::get_if<Miss>(&solved))
    return PowerRefusal{*miss, "Ceres: " + std::string(name_of(*miss))};
  const Solution& solution = std::get<Solution>(solved);
  estimate.covariance = spread_covariance(solution.covariance, free);
  estimate.reference_s = problem.reference_s;
  estimate.samples_used = static_cast<std::int64_t>(samples.time_s.size());
  estimate.samples_outside = samples.outside;
  estimate.noise_sigma_w = 1.0 / std::sqrt(samples.weight[0]);
  estimate.chi2_per_dof =
      2.0 * solution.cost / (static_cast<double>(samples.time_s.size()) - unknowns);
  estimate.iterations = solution.iterations;
  estimate.stop = PowerStop::converged;
  return estimate;
}

}  // namespace vildar
