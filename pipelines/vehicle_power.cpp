#include "pipelines/vehicle_power.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/clock.h"
#include "estimate/unmix.h"

namespace vildar {
namespace {

constexpr double kLeastAlone_s = 0.3;
constexpr double kMargin_s = 5.0;  // of the trace kept before and after a vehicle is in view
constexpr double kUnknownPassing_s =
    2.0;  // from the last sighting until it is past the photodiodes
constexpr double kLongestPassing_s = 5.0;
// Of the trace that is unmixed, before and after a vehicle is in view.
constexpr double kBefore_s = 0.5, kAfter_s = 4.0;
// Once it is past, light is that of others, some of whom the camera does not see yet.
constexpr double kPast_s = 0.5;
// Before it is in view a vehicle shines for as long as makes a difference.
constexpr double kComing_s = 2.0;
constexpr double kUnbounded_s = std::numeric_limits<double>::infinity();

bool overlap(ClipInterval one, ClipInterval other) {
  return one.from_s < other.to_s && other.from_s < one.to_s;
}

// When the light of a vehicle may end at a photodiode: where it drives past, or before that where a
// view that does not reach so far aside loses it. Nothing where its way is not known.
std::optional<ClipInterval> light_ends(const LitVehicle& lit, const PhotodiodeSite& photodiode) {
  constexpr double kEarlier = 2.0;             // lamps fade before the rim
  constexpr double kLeast = 0.5, kMost = 3.0;  // of its distance abeam
  constexpr double kSlack_s = 0.1, kSigmas = 4.0;
  if (!lit.way) return std::nullopt;
  const double at_s = lit.in_view.to_s;
  const MotionState last = lit.way->at(at_s);
  if (!(last.over_ground_mps > 0.0)) return std::nullopt;
  const double abeam_m = std::hypot(last.lateral_m - photodiode.position_m[1].mean,
                                    lit.way->lamp_height_m() - photodiode.position_m[2].mean);
  const double past_s =
      at_s + (last.range_m - photodiode.position_m[0].mean) / last.over_ground_mps;
  const double to_go_m = last.range_m - photodiode.position_m[0].mean;
  const double slack_s =
      kSlack_s +
      kSigmas *
          std::hypot(photodiode.time_offset_s.std, last.range_std_m / last.over_ground_mps,
                     to_go_m * last.speed_std_mps / (last.over_ground_mps * last.over_ground_mps));
  const double ahead_m =
      abeam_m * std::clamp(kEarlier / std::tan(photodiode.half_field_of_view_rad), kLeast, kMost);
  return ClipInterval{past_s - ahead_m / last.over_ground_mps - slack_s, past_s + slack_s};
}

const PhotodiodeSite& photodiode_of(std::span<const PowerPass> passes, const Site& site) {
  return site.photodiodes[static_cast<std::size_t>(passes.front().photodiode)];
}

std::vector<PowerPass> passes_ending_with(const LitVehicle& lit, const Site& site,
                                          std::span<const PowerPass> passes) {
  std::vector<PowerPass> found;
  if (passes.empty()) return found;
  const PhotodiodeSite& photodiode = photodiode_of(passes, site);
  const auto ends = light_ends(lit, photodiode);
  if (!ends) return found;
  for (const PowerPass& pass : passes) {
    const double ends_s = pass.to_s + photodiode.time_offset_s.mean;
    if (ends_s > ends->from_s && ends_s < ends->to_s) found.push_back(pass);
  }
  return found;
}

// Whether a vehicle whose way is known passes the photodiode of the passes while that is recorded.
bool ends_on_record(const LitVehicle& lit, const Site& site, std::span<const PowerTrace> traces,
                    std::span<const PowerPass> passes) {
  const auto trace = std::ranges::find(traces, passes.front().photodiode, &PowerTrace::photodiode);
  const PhotodiodeSite& photodiode = photodiode_of(passes, site);
  const auto ends = light_ends(lit, photodiode);
  return ends && trace != traces.end() &&
         ends->from_s > trace->time_s.front() + photodiode.time_offset_s.mean &&
         ends->to_s < trace->time_s.back() + photodiode.time_offset_s.mean;
}

// Who shines beside a vehicle: when, when of those whose way the camera does not tell, and the ways
// of all, its own first.
struct Company {
  std::vector<ClipInterval> shine, unknown;
  std::vector<const Trajectory*> ways;
  bool tail_lamps = false;  ///< among the ways: what they shine is to be taken out throughout
};

OfferedPower shared_out(const LitVehicle& vehicle, const Company& company, const Site& site,
                        std::span<const PowerTrace> traces) {
  OfferedPower offered;
  offered.in_time.reserve(traces.size());
  offered.own_light.reserve(traces.size());
  for (const PowerTrace& trace : traces) {
    const double offset_s =
        site.photodiodes[static_cast<std::size_t>(trace.photodiode)].time_offset_s.mean;
    VehiclePower power{&trace, true};
    auto in_time = alone_on_trace(trace, offset_s, vehicle.in_view, company.shine);
    const auto known = alone_on_trace(trace, offset_s, vehicle.in_view, company.unknown);
    if (!company.ways.empty() && known) {
      auto outcome = own_light(*known, site, company.ways, 0, vehicle.in_view.from_s - kBefore_s,
                               std::min(vehicle.in_view.to_s + kAfter_s, vehicle.past_s + kPast_s));
      const Miss* miss = std::get_if<Miss>(&outcome);
      const bool unexplained = miss && *miss == Miss::bad_fit;
      offered.unexplained = offered.unexplained || unexplained;
      if (unexplained || (!miss && company.ways.size() > 1)) {
        offered.own_light.push_back(miss ? PowerTrace{} : std::get<PowerTrace>(std::move(outcome)));
        power.own_light = &offered.own_light.back();
      }
    }
    if (in_time && company.tail_lamps && power.own_light)
      in_time = alone_on_trace(*power.own_light, offset_s, vehicle.in_view, company.shine);
    if (in_time) {
      offered.in_time.push_back(std::move(*in_time));
      power.trace = &offered.in_time.back();
      power.shared = false;
    }
    offered.power.push_back(power);
  }
  return offered;
}

}  // namespace

LitVehicle lit_vehicle(const VehicleTrack& track, const Site& site) {
  LitVehicle lit{
      track.id,
      {seconds_of(track.sightings.front().time), seconds_of(track.sightings.back().time)},
      0.0,
      {},
      track.direction == Direction::receding};
  std::vector<std::string> told_later;
  auto fitted = fit_trajectories(track, Camera(*site.camera), site, told_later);
  double passing_s = kUnknownPassing_s;
  if (auto* found = std::get_if<std::vector<Trajectory>>(&fitted)) {
    const MotionState last = found->front().at(lit.in_view.to_s);
    if (last.over_ground_mps > 0.0) passing_s = last.range_m / last.over_ground_mps;
    if (!track.ambiguous_identity) lit.way = std::move(found->front());
  }
  lit.past_s = lit.in_view.to_s;
  if (!lit.receding) lit.past_s += std::clamp(passing_s, 0.0, kLongestPassing_s);
  return lit;
}

bool company_known(ClipInterval in_view, double live_since_s) {
  return in_view.to_s + kAfter_s + kComing_s < live_since_s;
}

bool dark_since(const LitVehicle& lit, double since_s) { return lit.past_s < since_s - kBefore_s; }

OfferedPower offer_power(std::span<const LitVehicle> lit, std::size_t own, const Site& site,
                         std::span<const PowerTrace> traces) {
  const LitVehicle& vehicle = lit[own];
  Company company;
  std::vector<const Trajectory*> receding;
  if (vehicle.way) company.ways.push_back(&*vehicle.way);
  for (const LitVehicle& other : lit) {
    if (&other == &vehicle) continue;
    const bool known = vehicle.way && other.way;
    if (other.receding) {
      if (known) receding.push_back(&*other.way);
      continue;
    }
    company.shine.push_back({other.in_view.from_s, other.past_s});
    if (known)
      company.ways.push_back(&*other.way);
    else
      company.unknown.push_back(company.shine.back());
  }
  OfferedPower offered = shared_out(vehicle, company, site, traces);
  if (!offered.unexplained || receding.empty()) return offered;
  company.ways.insert(company.ways.end(), receding.begin(), receding.end());
  company.tail_lamps = true;
  OfferedPower with_tails = shared_out(vehicle, company, site, traces);
  for (std::size_t k = 0; k < traces.size(); ++k) {
    const PowerTrace *before = offered.power[k].own_light, *now = with_tails.power[k].own_light;
    const auto spoilt = [](const PowerTrace* light) { return light && light->time_s.empty(); };
    if (spoilt(now) || (spoilt(before) && !now)) return offered;
  }
  return with_tails;
}

std::optional<PowerPass> own_pass(std::span<const LitVehicle> lit, std::size_t own,
                                  const Site& site, std::span<const PowerTrace> traces,
                                  std::span<const PowerPass> passes) {
  constexpr std::size_t kMostOdd = 3;  // fewer than one vehicle in so many
  if (passes.empty()) return std::nullopt;
  const auto shines = [](const LitVehicle& vehicle) {
    return ClipInterval{vehicle.in_view.from_s - kBefore_s, vehicle.past_s};
  };
  bool in_company = false;
  std::size_t expected = 0, odd = 0;
  std::optional<PowerPass> found;
  std::vector<PowerPass> of_others;
  for (std::size_t i = 0; i < lit.size(); ++i) {
    if (lit[i].receding) continue;
    if (i != own && overlap(shines(lit[i]), shines(lit[own]))) {
      if (!lit[i].way) return std::nullopt;
      in_company = true;
    }
    const std::vector<PowerPass> ending = passes_ending_with(lit[i], site, passes);
    if (i == own && ending.size() == 1) found = ending.front();
    if (i != own) of_others.insert(of_others.end(), ending.begin(), ending.end());
    if (!ends_on_record(lit[i], site, traces, passes)) continue;
    ++expected;
    odd += ending.empty();
  }
  const auto is_found = [&](const PowerPass& pass) { return pass.to_s == found->to_s; };
  if (!in_company || !found || found->cut_off || (odd > 0 && kMostOdd * odd >= expected) ||
      std::ranges::any_of(of_others, is_found))
    return std::nullopt;
  return found;
}

std::optional<PowerTrace> alone_on_trace(const PowerTrace& trace, double time_offset_s,
                                         ClipInterval own, std::span<const ClipInterval> others) {
  std::vector<ClipInterval> busy(others.begin(), others.end());
  std::sort(busy.begin(), busy.end(),
            [](const ClipInterval& a, const ClipInterval& b) { return a.from_s < b.from_s; });
  ClipInterval best{0.0, 0.0};
  double best_own_s = kLeastAlone_s;
  double free_from_s = -kUnbounded_s;
  const auto consider = [&](double free_to_s) {
    const double own_s = std::min(free_to_s, own.to_s) - std::max(free_from_s, own.from_s);
    if (own_s < best_own_s) return;
    best = {free_from_s, free_to_s};
    best_own_s = own_s;
  };
  for (const ClipInterval& one : busy) {
    if (one.from_s > free_from_s) consider(one.from_s);
    free_from_s = std::max(free_from_s, one.to_s);
  }
  consider(kUnbounded_s);
  if (!(best.to_s > best.from_s)) return std::nullopt;

  const double from_s = std::max(best.from_s, own.from_s - kMargin_s) - time_offset_s;
  const double to_s = std::min(best.to_s, own.to_s + kMargin_s) - time_offset_s;
  const auto first = std::lower_bound(trace.time_s.begin(), trace.time_s.end(), from_s);
  const auto last = std::upper_bound(first, trace.time_s.end(), to_s);
  const auto power_from = trace.power_w.begin() + (first - trace.time_s.begin());
  return PowerTrace{trace, {first, last}, {power_from, power_from + (last - first)}};
}

}  // namespace vildar
