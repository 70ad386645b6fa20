#include "estimate/contradictions.h"

#include <algorithm>
#include <cmath>

#include "core/quantity.h"
#include "core/text.h"
#include "estimate/mixture.h"

namespace vildar {
namespace {

bool of_photodiode(Method method) {
  switch (method) {
    case Method::power_slope_photodiode:
    case Method::curved_angle_photodiode:
    case Method::ml_photodiode:
    case Method::delay_photodiodes: return true;
    default: return false;
  }
}

// Of a photodiode's methods.
bool by_law(Method method) { return method != Method::delay_photodiodes; }

std::string kmh_text(const SpeedEstimate& speed) {
  return fixed_text(kmh_from_mps(speed.lo95_mps), 1) + " to " +
         fixed_text(kmh_from_mps(speed.hi95_mps), 1) + " km/h";
}

}  // namespace

bool apart(const SpeedEstimate& one, const SpeedEstimate& other) {
  constexpr double kFar = 3.5;  // sigmas
  return std::abs(one.speed_mps - other.speed_mps) > kFar * std::hypot(one.std_mps, other.std_mps);
}

void check_sensors(std::span<const Trajectory> trajectories, VehicleResult& result) {
  constexpr double kSurer =
      2.0;  // of sigmas: the camera is trusted over a method so much less sure
  const bool reconciled = result.method == Method::fused;
  // Light that no beam explains on the way that the bearings tell is no light of this vehicle
  // alone: nothing is trusted that rests on its law.
  const bool denied = std::ranges::any_of(result.methods, [](const MethodResult& row) {
    const Miss* miss = std::get_if<Miss>(&row.speed);
    return row.method == Method::fused && miss && *miss == Miss::bad_fit;
  });
  for (MethodResult& row : result.methods) {
    const auto* speed = std::get_if<SpeedEstimate>(&row.speed);
    if (!speed || !of_photodiode(row.method)) continue;
    const SpeedEstimate camera = mixed_speed(trajectories, speed->time_s);
    if (!apart(*speed, camera)) continue;
    result.warnings.push_back(std::string(name_of(row.method)) + " (" + kmh_text(*speed) +
                              ") and " + std::string(name_of(result.method)) + " (" +
                              kmh_text(camera) +
                              ") disagree beyond their intervals; check the channel and the lamps");
    if (!reconciled && !(denied && by_law(row.method)) && speed->std_mps < kSurer * camera.std_mps)
      result.withheld = Miss::sensors_contradict;
    // By lamps unlike the law, which the joint fit lets them be.
    if (reconciled && by_law(row.method)) row.speed = Miss::outside_model;
  }
}

void check_law(std::span<VehicleResult> vehicles) {
  constexpr int kFewest = 2;
  int compared = 0, denied = 0;
  for (const VehicleResult& vehicle : vehicles) {
    const SpeedEstimate *delay = nullptr, *slope = nullptr;
    for (const MethodResult& row : vehicle.methods) {
      const auto* speed = std::get_if<SpeedEstimate>(&row.speed);
      if (row.method == Method::delay_photodiodes)
        delay = speed;
      else if (row.method != Method::ml_photodiode)
        slope = speed;
    }
    if (!delay || !slope || vehicle.method != Method::delay_photodiodes) continue;
    ++compared;
    denied += apart(*delay, *slope);
  }
  if (denied < kFewest || 2 * denied <= compared) return;
  for (VehicleResult& vehicle : vehicles) {
    if (vehicle.withheld || !by_law(vehicle.method)) continue;
    vehicle.withheld = Miss::outside_model;
    vehicle.warnings.push_back(std::string(name_of(vehicle.method)) +
                               " rests on the channel alone, which the delay of " +
                               std::to_string(denied) + " of " + std::to_string(compared) +
                               " vehicles between the photodiodes denies; check channel.gain_db "
                               "and path_loss_exponent, lamp_power_w, and the lanes");
  }
}

std::string warning_of_too_fast(Method method, const SpeedEstimate& speed) {
  return std::string(name_of(method)) + " gives " + fixed_text(kmh_from_mps(speed.speed_mps), 0) +
         " km/h, faster than vehicles drive; check the photodiodes' positions (metres), t_s "
         "(seconds), " +
         (by_law(method) ? "channel.gain_db and lamp_power_w, and the unit of the trace (W, A, V)"
                         : "and that both are sampled at the same times");
}

}  // namespace vildar
