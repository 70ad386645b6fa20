#include "estimate/power_method.h"

#include <cmath>
#include <functional>

#include "estimate/beam_doubt.h"
#include "estimate/curved_angle.h"
#include "estimate/pass_posterior.h"
#include "estimate/power_slope.h"
#include "estimate/speed_gate.h"
#include "optics/road.h"

namespace vildar {
namespace {

// What either of the two estimators says.
struct PaperFit {
  double speed_mps = 0.0;
  double along_at_zero_m = 0.0;  // path length from x = 0 at t = 0
  double sigma_mps = 0.0;
  double lag1_correlation = 0.0;
  std::int64_t samples = 0;
};

Outcome<PaperFit> paper_fit(const PowerSeries& series, const PowerCase& known) {
  if (known.bend == 0.0) {
    const auto outcome =
        fit_power_slope(series.time_s, series.power_w, known.law, Metres(known.perpendicular_m()));
    if (const Miss* miss = std::get_if<Miss>(&outcome)) return *miss;
    const auto& fit = std::get<PowerSlopeFit>(outcome);
    return PaperFit{fit.speed_mps, fit.range_at_zero_m + known.receiver_m.x(), fit.speed_sigma_mps,
                    fit.lag1_correlation, fit.samples_used};
  }
  const double radius_m = known.lane_radius_m();
  if (!(radius_m > 0.0)) return Miss::outside_model;
  const auto outcome = fit_curved_angle(series.time_s, series.power_w, known.law, Metres(radius_m));
  if (const Miss* miss = std::get_if<Miss>(&outcome)) return *miss;
  const auto& fit = std::get<CurvedAngleFit>(outcome);
  return PaperFit{fit.speed_mps, known.straight_m.mean + radius_m * fit.angle_at_zero_rad,
                  fit.speed_sigma_mps, fit.lag1_correlation, fit.samples_used};
}

PassMotion motion_at_middle(const PowerSeries& series, const PaperFit& fit) {
  double sum_s = 0.0;
  for (const double time_s : series.time_s) sum_s += time_s;
  const double middle_s = sum_s / static_cast<double>(series.time_s.size());
  return {middle_s, fit.speed_mps, fit.along_at_zero_m - fit.speed_mps * middle_s, 0.0};
}

double range_m(const PowerCase& known, double along_m) {
  return path_point(along_m, known.lateral_m.mean, known.bend, known.straight_m.mean,
                    known.radius_m.mean)
      .x_m;
}

// What the estimator returns for a noise-free pass of the full model at the speed found, less that
// speed: its own error.
Outcome<double> own_error_mps(const PowerSeries& series, const PowerCase& known,
                              const PaperFit& fit) {
  PowerSeries ideal;
  for (const double time_s : series.time_s) {
    const auto place =
        path_point(fit.along_at_zero_m - fit.speed_mps * time_s, known.lateral_m.mean, known.bend,
                   known.straight_m.mean, known.radius_m.mean);
    const double ahead_m = place.x_m - known.receiver_m.x();
    const double across_m = std::hypot(place.y_m - known.receiver_m.y(),
                                       known.lamp_height_m.mean - known.receiver_m.z());
    if (!(std::hypot(ahead_m, across_m) > 0.0)) return Miss::outside_model;
    ideal.time_s.push_back(time_s);
    ideal.power_w.push_back(known.law.power_w(ahead_m, across_m));
  }
  const auto outcome = paper_fit(ideal, known);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) return *miss;
  return std::get<PaperFit>(outcome).speed_mps - fit.speed_mps;
}

// Half the change of the speed between one sigma up and one sigma down.
double carried_mps(const PowerSeries& series, const PowerCase& known,
                   const std::function<void(PowerCase&, double)>& shift) {
  double speed_mps[2];
  for (const int side : {0, 1}) {
    PowerCase shifted = known;
    shift(shifted, side == 0 ? -1.0 : 1.0);
    const PowerLaw& law = shifted.law;
    if (!(law.path_loss_exponent > 0.0 && law.gain_w > 0.0 && std::isfinite(law.gain_w)))
      return INFINITY;  // what the site says of the law leaves none
    const auto outcome = paper_fit(series, shifted);
    const PaperFit* fit = std::get_if<PaperFit>(&outcome);
    if (!fit) return INFINITY;
    speed_mps[side] = fit->speed_mps;
  }
  return 0.5 * (speed_mps[1] - speed_mps[0]);
}

double prior_variance(const PowerSeries& series, const PowerCase& known) {
  double variance = 0.0;
  const auto add = [&](double std, const std::function<void(PowerCase&, double)>& shift) {
    if (std > 0.0) variance += std::pow(carried_mps(series, known, shift), 2);
  };
  add(known.log_gain_std,
      [](PowerCase& c, double side) { c.law.gain_w *= std::exp(side * c.log_gain_std); });
  add(known.exponent_std, [](PowerCase& c, double side) {
    c.law.path_loss_exponent += side * c.exponent_std;
    c.law.gain_w *= std::exp(side * c.exponent_std * c.log_gain_per_exponent.value_or(0.0));
  });
  add(known.lateral_m.std,
      [](PowerCase& c, double side) { c.lateral_m.mean += side * c.lateral_m.std; });
  add(known.lamp_height_m.std,
      [](PowerCase& c, double side) { c.lamp_height_m.mean += side * c.lamp_height_m.std; });
  if (series.background_std_w > 0.0) {
    const auto speed_mps = [&](double side) {
      PowerSeries shifted = series;
      for (double& power_w : shifted.power_w) power_w += side * series.background_std_w;
      const auto outcome = paper_fit(shifted, known);
      const PaperFit* fit = std::get_if<PaperFit>(&outcome);
      return fit ? fit->speed_mps : INFINITY;
    };
    variance += std::pow(0.5 * (speed_mps(1.0) - speed_mps(-1.0)), 2);
  }
  if (known.bend != 0.0)
    add(known.radius_m.std,
        [](PowerCase& c, double side) { c.radius_m.mean += side * c.radius_m.std; });
  return variance;
}

}  // namespace

double PowerCase::perpendicular_m() const {
  return std::hypot(lateral_m.mean - receiver_m.y(), receiver_m.z() - lamp_height_m.mean);
}

double PowerCase::lane_radius_m() const { return radius_m.mean - bend * lateral_m.mean; }

Outcome<PassMotion> paper_motion(const PowerSeries& series, const PowerCase& known) {
  const auto outcome = paper_fit(series, known);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) return *miss;
  const PassMotion motion = motion_at_middle(series, std::get<PaperFit>(outcome));
  if (!(motion.speed_mps > 0.0)) return Miss::outside_model;
  return motion;
}

Outcome<PowerSpeed> power_speed(const PowerSeries& series, const PowerCase& known) {
  const auto outcome = paper_fit(series, known);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) return *miss;
  const PaperFit& fit = std::get<PaperFit>(outcome);
  if (!(fit.speed_mps > 0.0)) return Miss::outside_model;
  const auto error = own_error_mps(series, known, fit);
  if (const Miss* miss = std::get_if<Miss>(&error)) return *miss;
  constexpr double kWorstOwnError = 0.25;
  const double own_mps = std::get<double>(error);
  if (std::abs(own_mps) > kWorstOwnError * fit.speed_mps) return Miss::outside_model;

  constexpr double kHighest = 0.995;
  const double lag = std::clamp(fit.lag1_correlation, 0.0, kHighest);
  const double scatter2 = fit.sigma_mps * fit.sigma_mps * (1.0 + lag) / (1.0 - lag);
  const PassMotion motion = motion_at_middle(series, fit);
  const auto posterior = pass_posterior(series, known, motion);
  if (const Miss* miss = std::get_if<Miss>(&posterior)) return *miss;
  const double ripple_nat = std::get<PassPosterior>(posterior).ripple_nat;
  const double beam2 =
      beam_variance(series, known, motion, ripple_nat, [&](const PowerSeries& unlike) {
        const auto pulled = paper_fit(unlike, known);
        const PaperFit* found = std::get_if<PaperFit>(&pulled);
        return found ? found->speed_mps : INFINITY;
      });
  const double std_mps =
      std::sqrt(scatter2 + own_mps * own_mps + prior_variance(series, known) + beam2);
  const double log_std = std_mps / fit.speed_mps;
  if (!(log_std < kNoSpeedLogStd)) return Miss::too_uncertain;
  constexpr double kTwoSided95 = 1.959963984540054;
  PowerSpeed found;
  found.speed.time_s = motion.reference_s;
  found.speed.speed_mps = fit.speed_mps;
  found.speed.std_mps = std_mps;
  found.speed.lo95_mps = fit.speed_mps * std::exp(-kTwoSided95 * log_std);
  found.speed.hi95_mps = fit.speed_mps * std::exp(kTwoSided95 * log_std);
  found.speed.samples_used = fit.samples;
  found.range_m = range_m(known, motion.along_m);
  return found;
}

}  // namespace vildar
