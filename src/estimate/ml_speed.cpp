#include "estimate/ml_speed.h"

#include <cmath>

#include "estimate/pass_posterior.h"
#include "estimate/speed_gate.h"
#include "optics/road.h"

namespace vildar {

Outcome<PowerSpeed> ml_speed(const PowerSeries& series, const PowerCase& known) {
  constexpr double kWorstChi2 = 4.0;
  constexpr double kMostPriorChi2 =
      21.6;  // of seven priors: three passes in a thousand; of eight six
  constexpr double kTwoSided95 = 1.959963984540054;
  const auto outcome = pass_posterior(series, known);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) return *miss;
  const auto& posterior = std::get<PassPosterior>(outcome);
  if (posterior.chi2_per_dof > kWorstChi2 || posterior.prior_chi2 > kMostPriorChi2)
    return Miss::bad_fit;
  if (posterior.unlike_the_law) return Miss::outside_model;
  const double log_std = posterior.log_speed_std;
  if (!(log_std < kNoSpeedLogStd)) return Miss::too_uncertain;
  PowerSpeed found;
  SpeedEstimate& speed = found.speed;
  speed.time_s = posterior.motion.reference_s;
  speed.speed_mps = posterior.motion.speed_mps;
  speed.std_mps = speed.speed_mps * log_std;
  speed.lo95_mps = speed.speed_mps * std::exp(-kTwoSided95 * log_std);
  speed.hi95_mps = speed.speed_mps * std::exp(kTwoSided95 * log_std);
  speed.samples_used = static_cast<std::int64_t>(series.time_s.size());
  found.range_m = path_point(posterior.motion.along_m, known.lateral_m.mean, known.bend,
                             known.straight_m.mean, known.radius_m.mean)
                      .x_m;
  return found;
}

}  // namespace vildar
