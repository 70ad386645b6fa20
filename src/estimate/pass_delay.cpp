#include "estimate/pass_delay.h"

#include <algorithm>
#include <cmath>

#include "estimate/delay_light.h"
#include "estimate/lane_choice.h"
#include "estimate/light_checks.h"
#include "estimate/power_blocks.h"

namespace vildar {
namespace {

bool dimmer(const PowerBlock& one, const PowerBlock& other) { return one.power_w < other.power_w; }

double peak_w(const PowerTrace& trace, const PowerPass& pass) {
  const auto begin = trace.time_s.begin();
  const auto first = std::lower_bound(begin, trace.time_s.end(), pass.from_s) - begin;
  const auto last = std::upper_bound(begin, trace.time_s.end(), pass.to_s) - begin;
  double most_w = 0.0;
  for (auto i = first; i < last; ++i)
    most_w = std::max(
        most_w, static_cast<double>(trace.power_w[static_cast<std::size_t>(i)]) - trace.ambient_w);
  return most_w;
}

// `pass`, found in the light of any photodiode, as `trace` shows it. A vehicle leaves photodiodes
// up the road earlier than those down the road, where the light of the one before it is still to be
// seen when its own pass begins up the road.
PowerPass as_seen_by(const PowerTrace& trace, PowerPass pass, const Site& site) {
  constexpr double kBlock_s = 0.02;
  if (trace.photodiode == pass.photodiode) return pass;
  const auto along_m = [&site](int photodiode) {
    return site.photodiodes.at(static_cast<std::size_t>(photodiode)).position_m[0].mean;
  };
  const bool earlier = along_m(trace.photodiode) > along_m(pass.photodiode);
  const std::vector<PowerBlock> blocks =
      block_means(trace, pass.from_s, pass.to_s, std::max(kBlock_s, trace.sample_period_s), 0.0);
  // Side by side noise makes either peak the earlier one.
  const double peaks_s = pass.peak_s + (earlier ? kBlock_s : -kBlock_s);
  const auto found = std::ranges::lower_bound(blocks, peaks_s, {}, &PowerBlock::time_s);
  const auto peak = earlier ? std::max_element(blocks.begin(), found, dimmer)
                            : std::max_element(found, blocks.end(), dimmer);
  if (peak == blocks.end()) return pass;
  if (std::abs(peak->time_s - pass.peak_s) > kBlock_s) pass.peak_s = peak->time_s;
  if (earlier) return pass;
  // From where the light of the one before it is gone.
  const auto before = std::max_element(blocks.begin(), found, dimmer);
  const auto lowest = std::min_element(before, peak, dimmer);
  if (lowest != peak && lowest != before &&
      lowest->power_w - trace.ambient_w < 0.5 * (before->power_w - trace.ambient_w))
    pass.from_s = lowest->time_s;
  return pass;
}

// Whether the light stands out at once and fades: of tail lamps that come into view as they drive
// past. An oncoming vehicle's grows, and is gone at once.
bool fades(const SeenPass& seen) {
  constexpr double kBlock_s = 0.02, kHalf = 0.5, kLonger = 2.0;
  const PowerTrace& trace = *seen.trace;
  const std::vector<PowerBlock> blocks = block_means(
      trace, seen.pass.from_s, seen.pass.to_s, std::max(kBlock_s, trace.sample_period_s), 0.0);
  if (blocks.empty()) return false;
  const auto peak = std::ranges::max_element(blocks, dimmer);
  const double half_w = trace.ambient_w + kHalf * (peak->power_w - trace.ambient_w);
  const auto dim = [&](const PowerBlock& block) { return block.power_w < half_w; };
  const auto first = std::find_if(std::make_reverse_iterator(peak), blocks.rend(), dim).base();
  const auto last = std::prev(std::find_if(peak, blocks.end(), dim));
  return last->time_s - peak->time_s > kLonger * (peak->time_s - first->time_s);
}

// The trace of this pass whose photodiode receives most, and so sees it best.
const PowerTrace& brightest(std::span<const PowerTrace> traces, const PowerPass& pass) {
  const PowerTrace* best = &traces.front();
  double best_ratio = -1.0;
  for (const PowerTrace& trace : traces) {
    const double ratio = peak_w(trace, pass) / std::max(trace.noise_sigma_w, 1e-300);
    if (ratio > best_ratio) {
      best_ratio = ratio;
      best = &trace;
    }
  }
  return *best;
}

}  // namespace

SeenPass best_seen(const PowerPass& found, const Site& site, std::span<const PowerTrace> traces) {
  const PowerTrace& trace = brightest(traces, found);
  const PowerPass pass = as_seen_by(trace, found, site);
  return {&trace, pass, peak_w(trace, pass)};
}

Outcome<DelayFit> pass_delay(const SeenPass& seen, const Site& site,
                             std::span<const PowerTrace> traces, std::size_t lanes,
                             double asked_from_s, double asked_to_s) {
  const double offset_s =
      site.photodiodes.at(static_cast<std::size_t>(seen.trace->photodiode)).time_offset_s.mean;
  if (two_way(site.road) && fades(seen)) return Miss::several_vehicles;
  std::vector<const PowerTrace*> all;
  for (const PowerTrace& trace : traces) {
    const PowerPass own = as_seen_by(trace, seen.pass, site);
    if (pulses(trace, own.from_s, own.peak_s)) return Miss::outside_model;
    all.push_back(&trace);
  }
  auto outcome = delay_speed(site, all, seen.pass.from_s + offset_s, seen.pass.to_s + offset_s,
                             asked_from_s, asked_to_s);
  auto* fit = std::get_if<DelayFit>(&outcome);
  if (!fit) return outcome;
  const double others_share = seen.pass.others_w / seen.peak_w;
  if (of_several(*fit, lanes, others_share)) return Miss::several_vehicles;
  if (seen.pass.others_w > 0.0) widen(*fit, others_std_mps(others_share, fit->speed.speed_mps));
  return outcome;
}

}  // namespace vildar
