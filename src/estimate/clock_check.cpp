#include "estimate/clock_check.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <variant>

#include "core/text.h"
#include "estimate/joint_fit.h"

namespace vildar {
namespace {

/// By how much time_offset_s must be greater, in steps.
std::optional<double> only_fitting_error_s(const Trajectory& camera_only, const Site& site,
                                           std::span<const VehiclePower> power) {
  constexpr double kStep_s = 0.25;
  constexpr int kFirstStep = 2, kSteps = 12;  // less may be a vehicle that begins to brake
  const auto fit_with = [&](const Site& one) {
    return fit_joint(camera_only, one, power, camera_only.from_s, camera_only.to_s);
  };
  const auto outcome = fit_with(site);
  const Miss* miss = std::get_if<Miss>(&outcome);
  if (!miss || *miss != Miss::bad_fit) return std::nullopt;
  Site other = site;
  for (int step = kFirstStep; step <= kSteps; ++step)
    for (const double error_s : {step * kStep_s, -step * kStep_s}) {
      for (std::size_t i = 0; i < other.photodiodes.size(); ++i) {
        Uncertain& offset_s = other.photodiodes[i].time_offset_s;
        offset_s.mean = site.photodiodes[i].time_offset_s.mean + error_s;
        offset_s.std = std::max(offset_s.std, 0.5 * kStep_s);
      }
      if (std::holds_alternative<JointFit>(fit_with(other))) return error_s;
    }
  return std::nullopt;
}

/// Clip time at which the vehicle has come to a place along the road, by where it goes on at the
/// end of its bearings.
std::optional<double> abeam_s(const Trajectory& trajectory, double along_m) {
  constexpr double kStep_s = 0.01, kLongest_s = 5.0;
  for (double after_s = 0.0; after_s < kLongest_s; after_s += kStep_s) {
    const PathPoint<double> place =
        vehicle_point(trajectory.fit.parameters.data(), trajectory.problem.setting,
                      trajectory.to_s + after_s - trajectory.problem.reference_s);
    if (place.x_m < along_m) return trajectory.to_s + after_s;
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
  const PhotodiodeSite& diode = site.photodiodes.at(static_cast<std::size_t>(trace.photodiode));
  const auto passes_s = abeam_s(camera_only, diode.position_m[0].mean);
  if (!passes_s) return false;
  const double at_s = *passes_s - diode.time_offset_s.mean;
  const double doubt_s = 2.0 * diode.time_offset_s.std;
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
         "time_offset_s " +
         fixed_text(std::abs(*error_s), 2) + " s " + (*error_s > 0.0 ? "greater" : "less") +
         " than the site's alone" + kNoSpeed;
}

}  // namespace vildar
