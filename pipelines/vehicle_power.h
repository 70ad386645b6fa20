#pragma once

#include <optional>
#include <span>
#include <vector>

#include "estimate/trajectory.h"
#include "estimate/vehicle.h"
#include "types/power.h"
#include "types/site.h"

namespace vildar {

/// Clip time.
struct ClipInterval {
  double from_s = 0.0;
  double to_s = 0.0;
};

/// A vehicle that shines on the photodiodes.
struct LitVehicle {
  int track_id = 0;
  ClipInterval in_view;
  double past_s = 0.0;            ///< clip time at which it shines no more on the photodiodes
  std::optional<Trajectory> way;  ///< nothing where the bearings do not tell it
  bool receding = false;          ///< only its tail lamps shine, too faint for a speed
};
LitVehicle lit_vehicle(const VehicleTrack& track, const Site& site);

/// Whether all that shine on the photodiodes beside a vehicle, until it is past them, have been
/// followed to their end. `live_since_s`: no vehicle that is still followed, or to come, was in
/// view before.
bool company_known(ClipInterval in_view, double live_since_s);

/// Whether a vehicle shone no more when those came that are in view from `since_s` on.
bool dark_since(const LitVehicle& lit, double since_s);

/// The traces as offered to one vehicle's estimate. Move only: `power` points into the other two.
struct OfferedPower {
  std::vector<PowerTrace> in_time, own_light;
  std::vector<VehiclePower> power;
  bool unexplained = false;  ///< light that none of the vehicles seen explains
};

/// Shares the traces out: to `lit[own]`, which is not receding, beside `lit`, all that shine near
/// its time. Tail lamps are reckoned with where the light is not explained without them: what they
/// shine is then taken out, and left out where it is not known.
OfferedPower offer_power(std::span<const LitVehicle> lit, std::size_t own, const Site& site,
                         std::span<const PowerTrace> traces);

/// Of `passes`, in the light of one photodiode and in its clock, the one that ends where `lit[own]`
/// passes the photodiodes and where no other of `lit` does. Nothing where it shines alone: its
/// light is then more than the pass; where its way is not known; and where a third of `lit` or more
/// pass without one that ends, as by a wrong clock.
std::optional<PowerPass> own_pass(std::span<const LitVehicle> lit, std::size_t own,
                                  const Site& site, std::span<const PowerTrace> traces,
                                  std::span<const PowerPass> passes);

/// The trace cut to the time in which `own` alone is in view, photodiode clock, or nothing where
/// that is shorter than 0.3 s of its own time in view. `others` are the times, in clip time, at
/// which other vehicles shine on the photodiode.
std::optional<PowerTrace> alone_on_trace(const PowerTrace& trace, double time_offset_s,
                                         ClipInterval own, std::span<const ClipInterval> others);

}  // namespace vildar
