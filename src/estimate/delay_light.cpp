#include "estimate/delay_light.h"

#include <algorithm>
#include <cmath>

#include "estimate/delay_parts.h"
#include "estimate/lane_choice.h"
#include "estimate/light_checks.h"
#include "estimate/light_edges.h"
#include "estimate/power_blocks.h"
#include "optics/road.h"

namespace vildar {
namespace {

constexpr double kClearLightSigmas = 10.0;

// Half a period of the mains, in which street lamps' flicker averages out, or several of them where
// the samples are sparse.
double block_length_s(double mains_hz, double sample_period_s) {
  constexpr double kFewestSamples = 4.0;
  const double half_period_s = 0.5 / mains_hz;
  return half_period_s * std::ceil(kFewestSamples * sample_period_s / half_period_s - 1e-9);
}

// Of a trace that may be hours long.
std::size_t first_sample(const PowerTrace& trace, const std::vector<PowerBlock>& blocks,
                         double offset_s) {
  if (blocks.empty()) return 0;
  const double from_s = blocks.front().time_s - offset_s - 0.5 * blocks.front().duration_s;
  return static_cast<std::size_t>(std::ranges::lower_bound(trace.time_s, from_s) -
                                  trace.time_s.begin());
}

// Variance of the samples within each block from their second differences, which the rise of the
// light does not enter.
std::vector<double> variances_w2(const PowerTrace& trace, const std::vector<PowerBlock>& blocks,
                                 double offset_s) {
  std::vector<double> found;
  std::size_t i = first_sample(trace, blocks, offset_s);
  for (const PowerBlock& block : blocks) {
    const double from_s = block.time_s - offset_s - 0.5 * block.duration_s;
    while (i < trace.time_s.size() && trace.time_s[i] < from_s) ++i;
    double sum = 0.0;
    int triples = 0;
    for (; i + 2 < trace.time_s.size() && trace.time_s[i + 2] < from_s + block.duration_s; ++i) {
      const double bend_w = static_cast<double>(trace.power_w[i + 2]) -
                            2.0 * static_cast<double>(trace.power_w[i + 1]) + trace.power_w[i];
      sum += bend_w * bend_w / 6.0;
      ++triples;
    }
    found.push_back(triples > 0 ? sum / triples : 0.0);
  }
  return found;
}

// The same where pulses were evened out: samples lie on lines between levels there, and only what
// blocks do shows their noise. From third differences, which neither rise nor bend enters.
std::vector<double> variances_between_w2(const std::vector<PowerBlock>& blocks) {
  constexpr double kOfDifference = 20.0;  // 1 + 9 + 9 + 1
  std::vector<double> found(blocks.size(), 0.0);
  for (std::size_t i = 0; i + 3 < blocks.size(); ++i) {
    const double difference_w = blocks[i + 3].power_w - blocks[i].power_w -
                                3.0 * (blocks[i + 2].power_w - blocks[i + 1].power_w);
    found[i + 1] = difference_w * difference_w / kOfDifference * blocks[i + 1].samples;
  }
  return found;
}

bool evened_out(const PowerTrace& trace, const std::vector<PowerBlock>& blocks, double offset_s) {
  return std::ranges::any_of(trace.pulsing, [&](const PulsingLight& light) {
    return light.from_s + offset_s < blocks.back().time_s &&
           light.to_s + offset_s > blocks.front().time_s;
  });
}

// How variance grows with the light, by the median over the brighter half of the blocks.
double median_share_w(const std::vector<double>& light_w, const std::vector<double>& variance_w2,
                      double floor_w2) {
  std::vector<double> sorted = light_w;
  const auto middle = static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), sorted.begin() + middle, sorted.end());
  const double half_w = sorted[static_cast<std::size_t>(middle)];
  std::vector<double> shares_w;
  for (std::size_t i = 0; i < light_w.size(); ++i)
    if (light_w[i] >= half_w && light_w[i] > 0.0)
      shares_w.push_back((variance_w2[i] - floor_w2) / light_w[i]);
  if (shares_w.empty()) return 0.0;
  const auto centre = shares_w.begin() + static_cast<std::ptrdiff_t>(shares_w.size() / 2);
  std::nth_element(shares_w.begin(), centre, shares_w.end());
  return std::max(0.0, *centre);
}

// Noise of a sample as a line in the power, sigma^2 = floor + share * light, by weighted least
// squares. Blocks in which the light ends or begins at an edge tell nothing of noise.
void set_sigmas(const PowerTrace& trace, double offset_s, std::vector<PowerBlock>& blocks) {
  const bool evened = evened_out(trace, blocks, offset_s);
  const std::vector<double> variance_w2 =
      evened ? variances_between_w2(blocks) : variances_w2(trace, blocks, offset_s);
  constexpr double kEdge = 8.0;  // of the variance: next to none of a block's samples scatter so
  std::vector<double> light_w;
  for (const PowerBlock& block : blocks)
    light_w.push_back(std::max(0.0, block.power_w - trace.ambient_w));
  const double noise_w2 = trace.noise_sigma_w * trace.noise_sigma_w;
  double floor_w2 = noise_w2;
  double share_w = median_share_w(light_w, variance_w2, floor_w2);
  for (int round = 0; round < 3; ++round) {
    double w = 0.0, wx = 0.0, wy = 0.0, wxx = 0.0, wxy = 0.0;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const double x = light_w[i], y = variance_w2[i];
      if (y > kEdge * (floor_w2 + share_w * x)) continue;
      const double weight = std::pow(floor_w2 + share_w * x, -2);
      w += weight;
      wx += weight * x;
      wy += weight * y;
      wxx += weight * x * x;
      wxy += weight * x * y;
    }
    const double determinant = w * wxx - wx * wx;
    if (!(determinant > 0.0)) break;
    share_w = std::max(0.0, (w * wxy - wx * wy) / determinant);
    // Blocks no longer than a pulse's period share levels with the next.
    floor_w2 = std::max(evened ? noise_w2 : 0.25 * floor_w2, (wy - share_w * wx) / w);
  }
  for (std::size_t i = 0; i < blocks.size(); ++i)
    blocks[i].sigma_w = std::hypot(std::sqrt((floor_w2 + share_w * light_w[i]) / blocks[i].samples),
                                   trace.rounding_sigma_w);
}

// The samples of blocks that are so long because there are few of them.
std::vector<PowerBlock> sparse_samples(const PowerTrace& trace, const Site& site, double offset_s,
                                       const std::vector<PowerBlock>& blocks) {
  std::vector<PowerBlock> samples;
  if (blocks.empty() || blocks.front().duration_s < 0.75 / site.mains_hz) return samples;
  std::size_t i = first_sample(trace, blocks, offset_s);
  for (const PowerBlock& block : blocks) {
    const double from_s = block.time_s - offset_s - 0.5 * block.duration_s;
    while (i < trace.time_s.size() && trace.time_s[i] < from_s) ++i;
    for (; i < trace.time_s.size() && trace.time_s[i] < from_s + block.duration_s; ++i)
      samples.push_back({trace.time_s[i] + offset_s, trace.sample_period_s, trace.power_w[i],
                         block.sigma_w * std::sqrt(block.samples), 1});
  }
  return samples;
}

Outcome<DelaySide> side_of(const PowerTrace& trace, const Site& site, double from_s, double to_s,
                           bool to_peak) {
  const double offset_s =
      site.photodiodes[static_cast<std::size_t>(trace.photodiode)].time_offset_s.mean;
  DelaySide side;
  side.ambient_w = {trace.ambient_w, std::max(trace.ambient_sigma_w, 1e-3 * trace.noise_sigma_w)};
  const double block_s = block_length_s(site.mains_hz, trace.sample_period_s);
  side.blocks = block_means(trace, from_s - offset_s, to_s - offset_s, block_s, offset_s);
  // A part of a block would be a mean over another length of road.
  const double whole = 0.95 * block_s / trace.sample_period_s - 1.0;
  std::erase_if(side.blocks, [&](const PowerBlock& block) { return block.samples < whole; });
  const auto peak = std::max_element(
      side.blocks.begin(), side.blocks.end(),
      [](const PowerBlock& a, const PowerBlock& b) { return a.power_w < b.power_w; });
  if (peak == side.blocks.end()) return Miss::too_few_samples;
  const double peak_w = peak->power_w - trace.ambient_w;
  if (!(peak_w > kClearLightSigmas * peak->sigma_w)) return Miss::below_noise;
  constexpr double kGone = 0.01;  // of the peak
  const auto ended = std::find_if(peak, side.blocks.end(), [&](const PowerBlock& block) {
    const double light_w = block.power_w - trace.ambient_w;
    return light_w < std::max(kClearLightSigmas * block.sigma_w, kGone * peak_w);
  });
  side.passed_s = (ended == side.blocks.end() ? std::prev(ended) : ended)->time_s;
  if (to_peak) side.blocks.erase(peak, side.blocks.end());
  if (side.blocks.empty()) return Miss::too_few_samples;
  set_sigmas(trace, offset_s, side.blocks);
  keep_between_edges(side.blocks, trace.ambient_w,
                     sparse_samples(trace, site, offset_s, side.blocks));
  if (side.blocks.empty()) return Miss::too_few_samples;
  return side;
}

// Whether both are for the most part of one time: else edges have left each another stretch of the
// light.
bool overlap(const std::vector<PowerBlock>& one, const std::vector<PowerBlock>& other) {
  const double both_s = std::min(one.back().time_s, other.back().time_s) -
                        std::max(one.front().time_s, other.front().time_s);
  const double shorter_s =
      std::min(one.back().time_s - one.front().time_s, other.back().time_s - other.front().time_s);
  return both_s >= 0.5 * shorter_s;
}

// Whether both saw about as much light at most: one that goes blind meanwhile did not.
bool as_bright(const DelayProblem& problem) {
  // What edges leave of one view may end before its peak: a fifth of the other's light is enough.
  constexpr double kMostApart_ln = 1.6;
  const auto most_w = [](const DelaySide& side) {
    double most = 0.0;
    for (const PowerBlock& block : side.blocks)
      most = std::max(most, block.power_w - side.ambient_w.mean);
    return most;
  };
  const double apart = std::log(most_w(problem.far) / most_w(problem.near));
  return std::abs(apart - problem.log_ratio.mean) < kMostApart_ln + 3.0 * problem.log_ratio.std;
}

}  // namespace

Outcome<DelayProblem> delay_problem(const Site& site, const PowerTrace& one,
                                    const PowerTrace& other, double from_s, double to_s,
                                    bool to_peak) {
  const auto diode = [&](const PowerTrace& trace) -> const PhotodiodeSite& {
    return site.photodiodes.at(static_cast<std::size_t>(trace.photodiode));
  };
  const auto along_m = [&](const PowerTrace& trace) {
    const auto& place_m = diode(trace).position_m;
    return road_position(site.road, place_m[0].mean, place_m[1].mean).along_m;
  };
  const bool ordered = along_m(one) <= along_m(other);
  const PowerTrace& near_trace = ordered ? one : other;
  const PowerTrace& far_trace = ordered ? other : one;
  const PhotodiodeSite& near = diode(near_trace);
  const PhotodiodeSite& far = diode(far_trace);
  auto pose = pair_pose(site, near, far);
  if (const Miss* miss = std::get_if<Miss>(&pose)) return *miss;
  DelayProblem problem;
  problem.pose = std::get<PairPose>(std::move(pose));
  problem.log_ratio = {std::log(far.gain_ratio.mean / near.gain_ratio.mean),
                       std::hypot(near.gain_ratio.std / near.gain_ratio.mean,
                                  far.gain_ratio.std / far.gain_ratio.mean)};
  for (const auto& [trace, side] :
       {std::pair{&near_trace, &problem.near}, std::pair{&far_trace, &problem.far}}) {
    auto found = side_of(*trace, site, from_s, to_s, to_peak);
    if (const Miss* miss = std::get_if<Miss>(&found)) return *miss;
    *side = std::get<DelaySide>(std::move(found));
  }
  if (!overlap(problem.near.blocks, problem.far.blocks) || !as_bright(problem))
    return Miss::bad_fit;
  return problem;
}

namespace {

// The whole pulses say most. Where light of others is in them, their brighter part; where the light
// ends in an edge that no smooth curve follows (a mask, another lamp coming in), their rise alone.
// Where the pulses are poorly alike, what sets them apart may have been taken for motion.
Outcome<DelayFit> pair_speed(const Site& site, const PowerTrace& one, const PowerTrace& other,
                             double from_s, double to_s, double asked_from_s, double asked_to_s) {
  const auto problem_of = [&](bool to_peak) {
    auto problem = delay_problem(site, one, other, from_s, to_s, to_peak);
    if (auto* posed = std::get_if<DelayProblem>(&problem)) {
      posed->asked_from_s = asked_from_s;
      posed->asked_to_s = asked_to_s;
    }
    return problem;
  };
  const auto contradicts = [](const Outcome<DelayFit>& outcome) {
    const Miss* miss = std::get_if<Miss>(&outcome);
    return miss && *miss == Miss::sensors_contradict;
  };
  const auto posed = problem_of(false);
  if (const Miss* miss = std::get_if<Miss>(&posed)) return *miss;
  const auto& problem = std::get<DelayProblem>(posed);
  auto outcome = fit_delay(problem);
  // Neither a part nor the rise alone can tell a gain from a delay.
  if (contradicts(outcome)) return outcome;
  DelayFit* whole = std::get_if<DelayFit>(&outcome);
  const bool alike = whole && is_alike(*whole), abreast = lanes_towards(site.road) > 1;
  if (whole && (is_quiet(*whole) || (alike && abreast))) return outcome;
  if (auto part = abreast ? std::nullopt : quiet_part(problem)) {
    DelayFit& stands = alike && agrees(problem, part->fit) ? *whole : part->fit;
    widen(stands, part->spread_mps);
    return stands;
  }
  if (alike) {
    widen_for_others(problem, *whole);
    return outcome;
  }
  const auto posed_rise = problem_of(true);
  if (const Miss* miss = std::get_if<Miss>(&posed_rise)) return *miss;
  const auto& rise = std::get<DelayProblem>(posed_rise);
  auto of_rise = fit_delay(rise);
  if (contradicts(of_rise)) return of_rise;
  if (auto* fit = std::get_if<DelayFit>(&of_rise);
      fit && (abreast ? vehicles_drive_so(*fit) : is_quiet(*fit))) {
    if (!abreast) {
      const auto spread_mps = spread_of_parts_mps(rise, *fit);
      if (!spread_mps && two_way(site.road)) return Miss::several_vehicles;
      widen(*fit, spread_mps.value_or(0.0));
    }
    return of_rise;
  }
  if (whole && !vehicles_drive_so(*whole)) return Miss::bad_fit;
  if (whole && !abreast) widen(*whole, spread_of_parts_mps(problem, *whole).value_or(0.0));
  return outcome;
}

void widen_for_pulses(const Site& site, const PowerTrace& one, const PowerTrace& other,
                      double from_s, double to_s, DelayFit& fit) {
  const auto diode_of = [&](const PowerTrace& trace) -> const PhotodiodeSite& {
    return site.photodiodes.at(static_cast<std::size_t>(trace.photodiode));
  };
  const auto& one_m = diode_of(one).position_m;
  const auto& other_m = diode_of(other).position_m;
  const double baseline_m =
      std::hypot(one_m[0].mean - other_m[0].mean, one_m[1].mean - other_m[1].mean);
  for (const PowerTrace* trace : {&one, &other}) {
    const double offset_s = diode_of(*trace).time_offset_s.mean;
    widen(fit, pulsing_std_mps(*trace, from_s - offset_s, to_s - offset_s, baseline_m,
                               fit.speed.speed_mps));
  }
}

}  // namespace

Outcome<DelayFit> delay_speed(const Site& site, std::span<const PowerTrace* const> traces,
                              double from_s, double to_s, double asked_from_s, double asked_to_s) {
  Outcome<DelayFit> best = Miss::no_scale;
  for (std::size_t i = 0; i < traces.size(); ++i)
    for (std::size_t j = i + 1; j < traces.size(); ++j) {
      auto outcome =
          pair_speed(site, *traces[i], *traces[j], from_s, to_s, asked_from_s, asked_to_s);
      auto* fit = std::get_if<DelayFit>(&outcome);
      const auto* known = std::get_if<DelayFit>(&best);
      if (fit) widen_for_pulses(site, *traces[i], *traces[j], from_s, to_s, *fit);
      if ((!known && (fit || (i == 0 && j == 1))) ||
          (fit && known && fit->speed.std_mps < known->speed.std_mps))
        best = std::move(outcome);
    }
  return best;
}

MethodResult delay_row(const Outcome<DelayFit>& outcome) {
  MethodResult row{Method::delay_photodiodes, Miss::no_scale, 0, ""};
  if (const Miss* miss = std::get_if<Miss>(&outcome)) {
    row.speed = *miss;
  } else {
    row.speed = std::get<DelayFit>(outcome).speed;
    row.samples = std::get<DelayFit>(outcome).speed.samples_used;
  }
  return row;
}

}  // namespace vildar
