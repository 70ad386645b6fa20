#include "condition/drift.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>

#include "condition/condition.h"
#include "condition/noise.h"
#include "condition/sliding.h"

namespace vildar {
namespace {

constexpr double kLevelBlock_s = 0.2;
constexpr double kLeastSamples = 4.0;
constexpr double kLongestPass_s = 30.0;
constexpr double kSigmas = 6.0;
constexpr std::size_t kShortestDark = 3;  // blocks: the cusp between two vehicles is no floor
constexpr double kLongestGap_s = 5.0;
constexpr double kLongestStep = 2.5;  // blocks
constexpr double kSlowestRate_hz = 20.0;

/// Blocks of a trace and which of them are dark.
struct Levels {
  std::vector<double> time_s;
  std::vector<double> power_w;
  std::vector<bool> dark;
  double block_s = 0.0;
  double sigma_w = 0.0;  ///< of one block
};

/// Scatter of neighbouring blocks; slow light does not enter, nor do a few fast changes.
double scatter_of(const std::vector<double>& power_w) {
  constexpr double kSigmaFromMedian = 0.6744897501960817;
  if (power_w.size() < 3) return 0.0;
  std::vector<double> bends_w;
  for (std::size_t i = 2; i < power_w.size(); ++i)
    bends_w.push_back(std::abs(power_w[i] - 2.0 * power_w[i - 1] + power_w[i - 2]));
  return median_of(bends_w) / (kSigmaFromMedian * std::sqrt(6.0));
}

Levels levels_of(const PowerTrace& trace) {
  Levels levels;
  levels.block_s = std::max(kLevelBlock_s, kLeastSamples * trace.sample_period_s);
  std::vector<double> sigmas_w;
  for (const PowerBlock& block :
       block_means(trace, trace.time_s.front(), trace.time_s.back(), levels.block_s)) {
    levels.time_s.push_back(block.time_s);
    levels.power_w.push_back(block.power_w);
    sigmas_w.push_back(block.sigma_w);
  }
  if (sigmas_w.empty()) return levels;
  levels.sigma_w = std::max(median_of(sigmas_w), scatter_of(levels.power_w));
  return levels;
}

/// Blocks near the highest curve under the trace that nothing shorter than a pass can lift. Only
/// stretches that lie wholly within the trace can: one that begins with a vehicle in view would
/// take the dip before the next one for the floor.
void mark_floor(Levels& levels) {
  constexpr double kReach_s = 0.5 * kLongestPass_s;
  // A little further back than forth, else the blocks of a steep slope fall out by turns.
  const double back_s = kReach_s + 1.5 * levels.block_s;
  std::vector<double> least_w = sliding_minimum(levels.time_s, levels.power_w, kReach_s);
  const double from_s = levels.time_s.front() + kReach_s - levels.block_s;
  const double to_s = levels.time_s.back() - kReach_s + levels.block_s;
  for (std::size_t i = 0; i < least_w.size(); ++i)
    if (levels.time_s[i] < from_s || levels.time_s[i] > to_s)
      least_w[i] = -std::numeric_limits<double>::infinity();
  const std::vector<double> floor_w = sliding_maximum(levels.time_s, least_w, back_s);
  const std::size_t n = levels.power_w.size();
  levels.dark.assign(n, false);
  for (std::size_t i = 0; i < n;) {
    std::size_t end = i;
    while (end < n && levels.power_w[end] < floor_w[end] + kSigmas * levels.sigma_w) ++end;
    if (end - i >= kShortestDark)
      std::fill(levels.dark.begin() + static_cast<std::ptrdiff_t>(i),
                levels.dark.begin() + static_cast<std::ptrdiff_t>(end), true);
    i = std::max(end, i + 1);
  }
}

/// Which of the blocks [first, last) a cubic follows; none unless it follows the first and the last
/// of them, and half of all, and lies above none. Vehicles may pass in between: they only add
/// light.
std::vector<bool> on_a_cubic(const Levels& levels, std::size_t first, std::size_t last) {
  constexpr double kShareOfRange = 0.02;
  constexpr Eigen::Index kEnds = 5;
  constexpr int kRounds = 20;
  const auto n = static_cast<Eigen::Index>(last - first);
  const double middle_s = 0.5 * (levels.time_s[first] + levels.time_s[last - 1]);
  const double half_s = 0.5 * (levels.time_s[last - 1] - levels.time_s[first]);
  Eigen::MatrixX4d powers(n, 4);
  Eigen::VectorXd light_w(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto block = first + static_cast<std::size_t>(i);
    const double u = (levels.time_s[block] - middle_s) / half_s;
    powers.row(i) << 1.0, u, u * u, u * u * u;
    light_w[i] = levels.power_w[block];
  }
  Eigen::VectorXd kept = Eigen::VectorXd::Ones(n);
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::Matrix4d normal = powers.transpose() * kept.asDiagonal() * powers;
    const Eigen::Vector4d right = powers.transpose() * kept.cwiseProduct(light_w);
    const Eigen::VectorXd cubic_w = powers * normal.ldlt().solve(right);
    const double range_w = cubic_w.maxCoeff() - cubic_w.minCoeff();
    const double allowed_w = std::max(kSigmas * levels.sigma_w, kShareOfRange * range_w);
    const Eigen::VectorXd error_w = light_w - cubic_w;
    const Eigen::VectorXd follows = (error_w.array() < allowed_w).cast<double>();
    if (follows == kept) {
      if (error_w.minCoeff() < -allowed_w) break;
      std::vector<bool> found(last - first);
      for (std::size_t i = 0; i < found.size(); ++i)
        found[i] = kept[static_cast<Eigen::Index>(i)] > 0.0;
      return found;
    }
    kept = follows;
    if (kept.mean() < 0.5 || kept.head(kEnds).minCoeff() == 0.0 ||
        kept.tail(kEnds).minCoeff() == 0.0)
      break;
  }
  return std::vector<bool>(last - first, false);
}

/// Calls `use(first, last)` for every run of blocks [first, last) that are, or are not, dark.
template <class Use>
void for_each_run(const Levels& levels, bool dark, Use use) {
  const std::size_t n = levels.dark.size();
  for (std::size_t i = 0; i < n;) {
    std::size_t end = i;
    while (end < n && levels.dark[end] == dark) ++end;
    if (end > i) use(i, end);
    i = std::max(end, i + 1);
  }
}

void mark(Levels& levels, std::size_t first, std::size_t last, bool dark) {
  std::fill(levels.dark.begin() + static_cast<std::ptrdiff_t>(first),
            levels.dark.begin() + static_cast<std::ptrdiff_t>(last), dark);
}

/// Stretches above the floor that are not of vehicles all the same. A change may fall within the
/// block at either end of them.
void mark_steady(Levels& levels) {
  constexpr double kShortest_s = 5.0;
  constexpr std::size_t kFewest = 15;  // blocks, for the four unknowns of a cubic
  const Levels found = levels;
  for_each_run(found, false, [&](std::size_t first, std::size_t last) {
    if (found.time_s[last - 1] - found.time_s[first] < kShortest_s) return;
    if (first > 0) ++first;
    if (last < found.dark.size()) --last;
    if (last - first < kFewest) return;
    const std::vector<bool> steady = on_a_cubic(found, first, last);
    std::copy(steady.begin(), steady.end(),
              levels.dark.begin() + static_cast<std::ptrdiff_t>(first));
  });
}

/// Takes from the ends of dark stretches what a vehicle already, or still, lights from far away. A
/// change of the ambient leaves a block or two between dark stretches, a vehicle more.
void unmark_tails(Levels& levels) {
  constexpr double kTail_s = 3.0;
  constexpr std::size_t kVehicle = 4;  // blocks
  const Levels found = levels;
  std::vector<bool> light_before(found.dark.size() + 1), light_from(found.dark.size() + 1);
  for_each_run(found, false, [&](std::size_t first, std::size_t last) {
    light_from[first] = light_before[last] = last - first >= kVehicle;
  });
  for_each_run(found, true, [&](std::size_t first, std::size_t last) {
    const double third_s = (found.time_s[last - 1] - found.time_s[first]) / 3.0;
    const double tail_s = std::min(kTail_s, third_s);
    std::size_t from = first, to = last;
    if (light_before[first])
      while (found.time_s[from] - found.time_s[first] < tail_s) ++from;
    if (light_from[last])
      while (found.time_s[last - 1] - found.time_s[to - 1] < tail_s) --to;
    mark(levels, first, from, false);
    mark(levels, to, last, false);
  });
}

/// Index of the first summit, twice as high over `floor_w` as `first`, after which the light falls
/// to half of it; of the highest where there is none such.
template <class Iterator>
std::ptrdiff_t first_summit(Iterator first, Iterator last, double floor_w) {
  Iterator summit = first;
  const double twice_w = floor_w + 2.0 * (*first - floor_w);
  for (Iterator at = first; at != last; ++at) {
    if (*at > *summit) summit = at;
    if (*summit > twice_w && *at - floor_w < 0.5 * (*summit - floor_w)) break;
  }
  return summit - first;
}

/// The most that the vehicle whose light is highest at some summit may light a block from afar:
/// over equal shares of the time that is left to its passing a power law grows by equal factors,
/// and whatever lies under it makes the first of them smaller. `later_w(share)`: light over the
/// floor at that share of the way from the block to the summit. None of what grows less.
template <class Later>
double far_light_w(Later later_w) {
  constexpr double kHalf = 0.5, kQuarter = 0.75;  // of the time has passed: half, a quarter is left
  // A law of exponent 0.4. Beams, noise, and light of others that is hidden by its own.
  constexpr double kLeastGrowth = 0.75, kSlack = 2.0;
  const double half_w = later_w(kHalf), quarter_w = later_w(kQuarter);
  return half_w > 0.0 && half_w < kLeastGrowth * quarter_w ? kSlack * half_w * half_w / quarter_w
                                                           : 0.0;
}

/// Light over the floor from one block on, forth or back in time: what a vehicle that passes there
/// may light it by. That is the next one, or the brightest of those within ten seconds.
template <class Iterator>
double lit_from(Iterator first, Iterator last, double floor_w, double block_s) {
  constexpr double kAhead_s = 10.0;
  const auto reach = std::min<std::ptrdiff_t>(last - first, std::lround(kAhead_s / block_s));
  const std::ptrdiff_t brightest = std::max_element(first, first + reach) - first;
  double most_w = 0.0;
  for (const std::ptrdiff_t summit : {first_summit(first, last, floor_w), brightest})
    most_w = std::max(most_w, far_light_w([&](double share) {
                        return first[std::lround(share * static_cast<double>(summit))] - floor_w;
                      }));
  return most_w;
}

/// Takes from dark stretches what the next vehicle lights from far away, or the last one still
/// does: in dense traffic all but the darkest moments.
void unmark_far_light(Levels& levels) {
  const std::vector<double>& power_w = levels.power_w;
  // All of the trace, also where no stretch is long enough to be told dark; the least of many.
  const double floor_w = std::ranges::min(power_w) + levels.sigma_w;
  for (std::size_t i = 0; i < power_w.size(); ++i) {
    if (!levels.dark[i] || power_w[i] < floor_w + kSigmas * levels.sigma_w) continue;
    const auto at = static_cast<std::ptrdiff_t>(i);
    const double lit_w = lit_from(power_w.begin() + at, power_w.end(), floor_w, levels.block_s) +
                         lit_from(power_w.rend() - at - 1, power_w.rend(), floor_w, levels.block_s);
    levels.dark[i] = power_w[i] - floor_w > lit_w;
  }
}

void unmark_short(Levels& levels) {
  const Levels found = levels;
  for_each_run(found, true, [&](std::size_t first, std::size_t last) {
    if (last - first < kShortestDark) mark(levels, first, last, false);
  });
}

/// Times and levels to interpolate between.
struct Curve {
  std::vector<double> time_s;
  std::vector<double> level_w;
};

Curve dark_blocks(const Levels& levels) {
  Curve dark;
  for (std::size_t i = 0; i < levels.dark.size(); ++i) {
    if (!levels.dark[i]) continue;
    dark.time_s.push_back(levels.time_s[i]);
    dark.level_w.push_back(levels.power_w[i]);
  }
  return dark;
}

/// What a change between neighbouring blocks must pass to be a step: more than noise, and than
/// what a slope does.
double step_threshold_w(const Curve& curve, const Levels& levels) {
  constexpr double kTimesUsual = 4.0;
  std::vector<double> changes_w;
  for (std::size_t i = 1; i < curve.level_w.size(); ++i)
    changes_w.push_back(std::abs(curve.level_w[i] - curve.level_w[i - 1]));
  const double usual_w = changes_w.empty() ? 0.0 : quantile_of(changes_w, 0.9);
  return std::max(kSigmas * levels.sigma_w, kTimesUsual * usual_w);
}

/// Medians of neighbouring dark blocks on the same side of every step.
Curve smoothed(const Curve& dark, double step_w) {
  constexpr std::size_t kReach = 10;  // blocks
  const std::size_t n = dark.level_w.size();
  std::vector<int> steps_before(n);
  for (std::size_t i = 1; i < n; ++i)
    steps_before[i] =
        steps_before[i - 1] + (std::abs(dark.level_w[i] - dark.level_w[i - 1]) > step_w ? 1 : 0);
  Curve curve{dark.time_s, {}};
  for (std::size_t i = 0; i < n; ++i) {
    // As far to one side as to the other, so that a slope does not shift the median.
    std::size_t reach = std::min({kReach, i, n - 1 - i});
    while (reach > 0 && (dark.time_s[i + reach] - dark.time_s[i - reach] > kLongestGap_s ||
                         steps_before[i + reach] != steps_before[i - reach]))
      --reach;
    const auto from = dark.level_w.begin() + static_cast<std::ptrdiff_t>(i - reach);
    std::vector<double> around(from, from + static_cast<std::ptrdiff_t>(2 * reach + 1));
    curve.level_w.push_back(median_of(around));
  }
  return curve;
}

/// Without the blocks within which a step falls.
Curve without_mixed(const Curve& curve, double step_w) {
  Curve kept;
  for (std::size_t i = 0; i < curve.level_w.size(); ++i) {
    const bool inner = i > 0 && i + 1 < curve.level_w.size();
    const double before_w = inner ? curve.level_w[i] - curve.level_w[i - 1] : 0.0;
    const double after_w = inner ? curve.level_w[i + 1] - curve.level_w[i] : 0.0;
    if (std::min(before_w, after_w) > step_w || std::max(before_w, after_w) < -step_w) continue;
    kept.time_s.push_back(curve.time_s[i]);
    kept.level_w.push_back(curve.level_w[i]);
  }
  return kept;
}

/// Index of the first sample after a step between `from` and `to`: where the means of what comes
/// before and after it leave the least scatter.
std::size_t step_at(const PowerTrace& trace, std::size_t from, std::size_t to) {
  double before = 0.0, after = 0.0;
  for (std::size_t i = from; i < to; ++i) after += trace.power_w[i];
  double best = -1.0;
  std::size_t at = from;
  for (std::size_t i = from; i < to; ++i) {
    const auto left = static_cast<double>(i - from), right = static_cast<double>(to - i);
    const double explained = (left > 0.0 ? before * before / left : 0.0) + after * after / right;
    if (explained > best) {
      best = explained;
      at = i;
    }
    before += trace.power_w[i];
    after -= trace.power_w[i];
  }
  return at;
}

/// Takes the curve less `reference_w` from the samples.
void subtract(const Curve& curve, double step_w, double longest_step_s, double reference_w,
              PowerTrace& trace) {
  const auto take = [&](std::size_t from, std::size_t to, double level_w, double slope_w_per_s) {
    for (std::size_t i = from; i < to; ++i)
      trace.power_w[i] -= static_cast<float>(
          level_w + slope_w_per_s * (trace.time_s[i] - trace.time_s[from]) - reference_w);
  };
  const auto first_from = [&](double time_s) {
    return static_cast<std::size_t>(
        std::lower_bound(trace.time_s.begin(), trace.time_s.end(), time_s) - trace.time_s.begin());
  };
  const std::size_t knots = curve.time_s.size();
  std::size_t from = first_from(curve.time_s.front());
  take(0, from, curve.level_w.front(), 0.0);
  for (std::size_t k = 0; k + 1 < knots; ++k) {
    const std::size_t to = first_from(curve.time_s[k + 1]);
    const double apart_s = curve.time_s[k + 1] - curve.time_s[k];
    const double apart_w = curve.level_w[k + 1] - curve.level_w[k];
    if (std::abs(apart_w) > step_w && apart_s < longest_step_s) {
      const std::size_t step = step_at(trace, from, to);
      take(from, step, curve.level_w[k], 0.0);
      take(step, to, curve.level_w[k + 1], 0.0);
    } else if (from < to) {
      const double slope_w_per_s = apart_w / apart_s;
      const double late_s = trace.time_s[from] - curve.time_s[k];
      take(from, to, curve.level_w[k] + slope_w_per_s * late_s, slope_w_per_s);
    }
    from = to;
  }
  take(from, trace.time_s.size(), curve.level_w.back(), 0.0);
}

}  // namespace

void remove_drift(PowerTrace& trace) {
  if (trace.time_s.size() < 2 || trace.time_s.back() - trace.time_s.front() < kLongestPass_s ||
      trace.sample_period_s * kSlowestRate_hz > 1.0)
    return;
  Levels levels = levels_of(trace);
  if (levels.power_w.size() < 2 * kShortestDark) return;
  mark_floor(levels);
  mark_steady(levels);
  unmark_tails(levels);
  const auto range_of = [](const Curve& curve) {
    if (curve.level_w.empty()) return 0.0;
    const auto [least, most] = std::ranges::minmax(curve.level_w);
    return most - least;
  };
  const Curve dark = dark_blocks(levels);
  if (dark.level_w.empty()) return;
  const double step_w = step_threshold_w(dark, levels);
  Curve curve = smoothed(dark, step_w);
  const double range_w = range_of(curve);
  if (!(range_w > kSigmas * levels.sigma_w)) return;
  unmark_far_light(levels);
  unmark_short(levels);
  if (!(range_of(smoothed(dark_blocks(levels), step_w)) > kSigmas * levels.sigma_w)) return;
  trace.drift_w = range_w;
  curve = without_mixed(curve, step_w);
  std::vector<double> sorted_w = curve.level_w;
  trace.ambient_w = median_of(sorted_w);
  trace.ambient_sigma_w = levels.sigma_w;
  subtract(curve, step_w, kLongestStep * levels.block_s, trace.ambient_w, trace);
}

}  // namespace vildar
