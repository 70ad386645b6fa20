#include "estimate/flashers.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

namespace vildar {
namespace {

constexpr double kTrendReach_s = 0.35, kLevelsReach_s = 0.6;
constexpr double kLeastStep = 0.1, kClearOfScatter = 8.0;  // of ln light, of its scatter
constexpr double kLit = 1.0 / 3.0;

struct LightSeries {
  std::vector<std::size_t> sighting;
  std::vector<double> time_s, log_light;

  std::size_t size() const { return time_s.size(); }
};

using Lamp = std::optional<LampSighting> VehicleSighting::*;

LightSeries series_of(const VehicleTrack& track, Lamp lamp) {
  LightSeries series;
  for (std::size_t k = 0; k < track.sightings.size(); ++k) {
    const VehicleSighting& one = track.sightings[k];
    if (one.both_in_one || !(one.*lamp) || !((one.*lamp)->flux > 0.0)) continue;
    series.sighting.push_back(k);
    series.time_s.push_back(seconds_of(one.time));
    series.log_light.push_back(std::log((one.*lamp)->flux));
  }
  return series;
}

// The values of `of` within `reach_s` of the time of `at`; times rise.
class Surroundings {
 public:
  Surroundings(const std::vector<double>& time_s, double reach_s)
      : time_s_(time_s), reach_s_(reach_s) {}

  const std::vector<double>& move_to(double at_s, const std::vector<double>& of) {
    while (first_ < of.size() && time_s_[first_] < at_s - reach_s_) ++first_;
    while (end_ < of.size() && time_s_[end_] <= at_s + reach_s_) ++end_;
    near_.assign(of.begin() + static_cast<std::ptrdiff_t>(first_),
                 of.begin() + static_cast<std::ptrdiff_t>(end_));
    return near_;
  }

 private:
  const std::vector<double>& time_s_;
  double reach_s_;
  std::size_t first_ = 0, end_ = 0;
  std::vector<double> near_;
};

double quantile_of(std::vector<double> values, double share) {
  const auto at = values.begin() +
                  static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// ln light without what it changes by steadily.
std::vector<double> levels_of(const LightSeries& series) {
  std::vector<double> slope;
  for (std::size_t k = 0; k + 1 < series.size(); ++k)
    slope.push_back((series.log_light[k + 1] - series.log_light[k]) /
                    (series.time_s[k + 1] - series.time_s[k]));
  std::vector<double> levels{0.0};
  Surroundings near(series.time_s, kTrendReach_s);
  for (std::size_t k = 0; k < slope.size(); ++k) {
    const double trend = quantile_of(near.move_to(series.time_s[k], slope), 0.5);
    levels.push_back(levels.back() +
                     (slope[k] - trend) * (series.time_s[k + 1] - series.time_s[k]));
  }
  return levels;
}

// One sigma of single ones, by the steps between neighbours.
double scatter_of(const std::vector<double>& levels) {
  std::vector<double> steps;
  for (std::size_t k = 1; k < levels.size(); ++k)
    steps.push_back(std::abs(levels[k] - levels[k - 1]));
  return quantile_of(std::move(steps), 0.5) / (0.6745 * std::numbers::sqrt2);
}

struct TwoLevels {
  std::vector<bool> stepping;  // there are two about this time
  std::vector<double> height;  // above the lower one, of the step to the upper one
};

// None where light does not keep to two levels.
std::optional<TwoLevels> two_levels(const LightSeries& series, const std::vector<double>& levels) {
  constexpr double kMostBetween = 0.2;
  const double least_step = std::max(kLeastStep, kClearOfScatter * scatter_of(levels));
  TwoLevels two;
  Surroundings near(series.time_s, kLevelsReach_s);
  int stepping = 0, between = 0;
  for (std::size_t k = 0; k < series.size(); ++k) {
    const std::vector<double>& around = near.move_to(series.time_s[k], levels);
    const double lower = quantile_of(around, 0.1);
    const double step = quantile_of(around, 0.9) - lower;
    const bool steps = step > least_step;
    const double height = steps ? (levels[k] - lower) / step : 0.0;
    two.stepping.push_back(steps);
    two.height.push_back(height);
    stepping += steps;
    between += steps && height > 0.25 && height < 0.75;
  }
  if (between > kMostBetween * stepping) return std::nullopt;
  return two;
}

// Flashes and the pauses between them last as they may: 0.3 to 0.8 of 0.5 to 1 s, and a picture.
// Single pictures are off by what a coder does to them.
bool flashes(const LightSeries& series, const TwoLevels& two) {
  constexpr double kShortest_s = 0.12, kLongest_s = 0.85, kBlip_s = 0.05;
  constexpr int kFewestWhole = 2;
  int whole = 0, other = 0;
  std::optional<double> changed_s;
  std::optional<bool> was_lit;
  Surroundings near(series.time_s, kBlip_s);
  for (std::size_t k = 0; k < series.size(); ++k) {
    const bool lit = quantile_of(near.move_to(series.time_s[k], two.height), 0.5) > kLit;
    if (!two.stepping[k]) {
      was_lit.reset();
      changed_s.reset();
      continue;
    }
    if (was_lit && lit != *was_lit) {
      if (changed_s) {
        const double lasts_s = series.time_s[k] - *changed_s;
        ++(lasts_s > kShortest_s && lasts_s < kLongest_s ? whole : other);
      }
      changed_s = series.time_s[k];
    }
    was_lit = lit;
  }
  return whole >= kFewestWhole && 4 * other <= whole;
}

void leave_out_flashes(VehicleTrack& track, Lamp lamp) {
  constexpr std::size_t kFewest = 20;
  const LightSeries series = series_of(track, lamp);
  if (series.size() < kFewest) return;
  const auto two = two_levels(series, levels_of(series));
  if (!two || !flashes(series, *two)) return;
  for (std::size_t k = 0; k < series.size(); ++k)
    if (two->height[k] > kLit) (track.sightings[series.sighting[k]].*lamp).reset();
}

}  // namespace

VehicleTrack without_flashes(VehicleTrack track) {
  leave_out_flashes(track, &VehicleSighting::left);
  leave_out_flashes(track, &VehicleSighting::right);
  std::erase_if(track.sightings,
                [](const VehicleSighting& one) { return !one.left && !one.right; });
  return track;
}

bool lit_in_turn(const VehicleTrack& track) {
  constexpr double kWay_s = 1.2, kLeastWay_s = 0.5, kLongestStep_s = 0.35, kStep_px = 3.0;
  constexpr double kStands = 0.5, kMostly = 0.75;
  constexpr int kFewest = 8;
  int steps = 0, standing = 0;
  for (const Lamp which : {&VehicleSighting::left, &VehicleSighting::right}) {
    std::vector<VehicleSighting> lit;
    std::ranges::copy_if(track.sightings, std::back_inserter(lit),
                         [&](const VehicleSighting& one) { return (one.*which).has_value(); });
    // A receding light's way slows down in the image: read backwards it is one that comes nearer.
    if (track.direction == Direction::receding) std::ranges::reverse(lit);
    const auto between = [&](std::size_t from, std::size_t to) {
      return std::pair<double, Eigen::Vector2d>(
          std::abs(seconds_of(lit[to].time) - seconds_of(lit[from].time)),
          (lit[to].*which)->centre_px - (lit[from].*which)->centre_px);
    };
    for (std::size_t i = 0, first = 0; i < lit.size(); ++i) {
      while (between(first, i).first > kWay_s) ++first;
      const auto [way_s, way_px] = between(first, i);
      if (way_s < kLeastWay_s) continue;
      for (std::size_t before = i; before-- > first;) {
        const auto [step_s, step_px] = between(before, i);
        if (step_s > kLongestStep_s) break;
        const Eigen::Vector2d told_px = step_s / way_s * way_px;
        if (told_px.norm() < kStep_px) continue;
        ++steps;
        standing += step_px.dot(told_px) < kStands * told_px.squaredNorm();
        break;
      }
    }
  }
  return steps >= kFewest && standing > kMostly * steps;
}

}  // namespace vildar
