#include "estimate/clock_check.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <variant>

#include "core/text.h"
#include "estimate/joint_fit.h"

namespace vildar {
namespace {

/// By how much time_offset_s must be greater, in steps; nothing where what the site says of it, or
/// half a step more, will do.
std::optional<double> only_fitting_error_s(const Trajectory& camera_only, const Site& site,
                                           std::span<const VehiclePower> power) {
  constexpr double kStep_s = 0.5, kSigmas = 3.0;
  constexpr int kSteps = 6;
  const double from_s = camera_only.from_s, to_s = camera_only.to_s;
  const auto is_bad_fit = [](const Outcome<JointFit>& fit) {
    const Miss* miss = std::get_if<Miss>(&fit);
    return miss && *miss == Miss::bad_fit;
  };
  double told_std_s = 0.0;
  Site other = site;
  const auto fit_at = [&](double error_s) {
    for (std::size_t i = 0; i < other.photodiodes.size(); ++i) {
      const Uncertain& told_s = site.photodiodes[i].time_offset_s;
      other.photodiodes[i].time_offset_s = {told_s.mean + error_s,
                                            std::max(told_s.std, 0.5 * kStep_s)};
      told_std_s = std::max(told_std_s, told_s.std);
    }
    return fit_joint_from(camera_only, other, power, from_s, to_s, 0.0);
  };
  if (!is_bad_fit(fit_joint(camera_only, site, power, from_s, to_s)) || !is_bad_fit(fit_at(0.0)))
    return std::nullopt;
  for (int step = 1; step <= kSteps; ++step)
    for (const double error_s : {step * kStep_s, -step * kStep_s})
      if (std::abs(error_s) >= kSigmas * told_std_s &&
          std::holds_alternative<JointFit>(fit_at(error_s)))
        return error_s;
  return std::nullopt;
}

/// Clip time at which the vehicle has come to a place along the road, by where it goes on at the
/// end of its bearings, and how much later that may be if it brakes then.
struct Abeam {
  double time_s = 0.0, later_s = 0.0;
};

std::optional<Abeam> abeam(const Trajectory& trajectory, double along_m) {
  constexpr double kStep_s = 0.01, kLongest_s = 5.0, kSigmas = 2.0, kBrakes_mps2 = 3.0;
  for (double time_s = trajectory.from_s; time_s < trajectory.to_s + kLongest_s;
       time_s += kStep_s) {
    const MotionState state = trajectory.at(time_s);
    if (state.range_m > along_m) continue;
    if (!(state.over_ground_mps > 0.0)) return std::nullopt;
    const double unseen_s = std::max(0.0, time_s - trajectory.to_s);
    const double off_m = kSigmas * std::hypot(state.range_std_m, unseen_s * state.speed_std_mps) +
                         0.5 * kBrakes_mps2 * unseen_s * unseen_s;
    return Abeam{time_s, off_m / state.over_ground_mps};
  }
  return std::nullopt;
}

double light_w(const PowerTrace& trace, double from_s, double to_s) {
  const auto sample_at = [&](double time_s) {
    return std::ranges::lower_bound(trace.time_s, time_s) - trace.time_s.begin();
  };
  double sum_w = 0.0;
  const auto first = sample_at(from_s), last = sample_at(to_s);
  for (auto i = first; i < last; ++i)
    sum_w += trace.power_w[static_cast<std::size_t>(i)] - trace.ambient_w;
  return last > first ? sum_w / static_cast<double>(last - first) : NAN;
}

bool rises_past(const Trajectory& camera_only, const Site& site, const PowerTrace& trace) {
  constexpr double kNear_s = 0.15, kFar_s = 0.3, kRises = 1.3, kClearSigmas = 20.0;
  constexpr double kOffsetSigmas = 3.0;
  const PhotodiodeSite& diode = site.photodiodes.at(static_cast<std::size_t>(trace.photodiode));
  const auto passes = abeam(camera_only, diode.position_m[0].mean);
  if (!passes) return false;
  const double at_s = passes->time_s - diode.time_offset_s.mean;
  const double doubt_s = kOffsetSigmas * diode.time_offset_s.std + passes->later_s;
  const double before_w = light_w(trace, at_s - kFar_s, at_s - kNear_s);
  const double after_w = light_w(trace, at_s + doubt_s + kNear_s, at_s + doubt_s + kFar_s);
  return before_w > kClearSigmas * trace.noise_sigma_w && after_w > kRises * before_w;
}

}  // namespace

std::optional<std::string> clock_fault(const Trajectory& camera_only, const Site& site,
                                       std::span<const VehiclePower> power) {
  constexpr const char* kNoSpeed = ": no speed is taken from it; check both clocks";
  if (std::ranges::any_of(power, [&](const VehiclePower& offered) {
        return !offered.shared && rises_past(camera_only, site, *offered.trace);
      }))
    return std::string(
               "the photodiodes' light goes on rising when the camera has the vehicle past") +
           kNoSpeed;
  const auto error_s = only_fitting_error_s(camera_only, site, power);
  if (!error_s) return std::nullopt;
  return "the photodiodes' light comes when the camera has the vehicle there with a "
         "time_offset_s about " +
         fixed_text(std::abs(*error_s), 2) + " s " + (*error_s > 0.0 ? "greater" : "less") +
         " than the site's alone" + kNoSpeed;
}

}  // namespace vildar
