#include "estimate/beam_doubt.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "estimate/pass_light.h"

namespace vildar {

double beam_variance(const PowerSeries& series, const PowerCase& known, const PassMotion& motion,
                     double ripple_nat, const std::function<double(const PowerSeries&)>& estimate) {
  constexpr double kStep_nat = 0.01;
  constexpr double kHeadlamps_nat = 1.0;
  const bool any_lamps = known.log_gain_per_exponent.has_value();
  const auto shapes = beam_shapes(known, motion, series.time_s);
  double variance = 0.0;
  for (std::size_t k = 0; k < kBeamShapes; ++k) {
    double found[2];
    for (const int side : {0, 1}) {
      PowerSeries beside = series;
      for (std::size_t i = 0; i < beside.power_w.size(); ++i)
        beside.power_w[i] *= std::exp((side == 0 ? -kStep_nat : kStep_nat) * shapes[i][k]);
      found[side] = estimate(beside);
    }
    const double pull = (found[1] - found[0]) / (2.0 * kStep_nat);
    const double least_nat = any_lamps && is_smooth(k) ? kHeadlamps_nat : 0.0;
    variance += std::pow(pull * beam_shape_std(std::max(ripple_nat, least_nat), k), 2);
  }
  return std::isfinite(variance) ? variance : INFINITY;
}

}  // namespace vildar
