#include "track/resume.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "core/median.h"

namespace vildar {
namespace {

struct Look {
  double time_s, along_m, lateral_m, depth_m;
};

// The last at both lamps, for so long, in order of time.
std::vector<Look> last_looks(const Vehicle& vehicle, const RoadView& view, double longest_s) {
  const std::vector<LampRecord> left = records_of(vehicle, vehicle.left, vehicle.past_left);
  const std::vector<LampRecord> right = records_of(vehicle, vehicle.right, vehicle.past_right);
  std::vector<Look> looks;
  for (auto one = left.rbegin(), other = right.rbegin();
       one != left.rend() && other != right.rend();) {
    const std::int64_t frame = std::max(one->frame, other->frame);
    if (!looks.empty() && looks.front().time_s - seconds_of(one->time) > longest_s) break;
    if (one->frame == other->frame && one->merged_px == 0.0 && other->merged_px == 0.0) {
      const PairFit fit = view.fit_pair(one->at_px, other->at_px, 1.0);
      const RoadPosition at =
          view.road_at(0.5 * (one->at_px + other->at_px), fit.inverse_depth_per_m);
      looks.push_back(
          {seconds_of(one->time), at.along_m, at.lateral_m, 1.0 / fit.inverse_depth_per_m});
    }
    one += one->frame == frame;
    other += other->frame == frame;
  }
  std::ranges::reverse(looks);
  return looks;
}

double mean(std::span<const Look> looks, double Look::*value) {
  double sum = 0.0;
  for (const Look& look : looks) sum += look.*value;
  return sum / static_cast<double>(looks.size());
}

double middle(std::span<const Look> looks, double Look::*value) {
  std::vector<double> values;
  for (const Look& look : looks) values.push_back(look.*value);
  return median(std::move(values));
}

/// Along the road at a steady speed, by medians (Theil 1950, Sen 1968): the last looks at a vehicle
/// that is being lost are often of lamps that run together with others.
class Way {
 public:
  explicit Way(std::span<const Look> looks) : time_s_(mean(looks, &Look::time_s)) {
    std::vector<double> speeds_mps, starts_m, off_m;
    for (std::size_t i = 0; i < looks.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        speeds_mps.push_back((looks[i].along_m - looks[j].along_m) /
                             (looks[i].time_s - looks[j].time_s));
    speed_mps_ = median(std::move(speeds_mps));
    double spread_s2 = 0.0;
    for (const Look& look : looks) {
      const double ahead_s = look.time_s - time_s_;
      starts_m.push_back(look.along_m - speed_mps_ * ahead_s);
      spread_s2 += ahead_s * ahead_s;
    }
    start_m_ = median(starts_m);
    for (const double start_m : starts_m) off_m.push_back(start_m - start_m_);
    const double scatter_m = robust_sigma(std::move(off_m));
    start_sigma_m_ = kMedianOverMean * scatter_m / std::sqrt(static_cast<double>(looks.size()));
    speed_sigma_mps_ = scatter_m / std::sqrt(spread_s2);
  }
  double along_m(double time_s) const { return start_m_ + speed_mps_ * (time_s - time_s_); }
  double sigma_m(double time_s) const {
    return std::hypot(start_sigma_m_, speed_sigma_mps_ * (time_s - time_s_));
  }

 private:
  static constexpr double kMedianOverMean = 1.25;  // sigmas, of a normal law
  double time_s_, start_m_ = 0.0, speed_mps_ = 0.0, start_sigma_m_ = 0.0, speed_sigma_mps_ = 0.0;
};

// Two vehicles do not stand in one place: what was seen there was the same lamps.
bool in_its_place(std::span<const Look> looks, const Way& way, double lateral_m) {
  constexpr double kInLength_m = 3.0, kInWidth_m = 0.7;
  std::vector<double> off_m;
  for (const Look& look : looks) off_m.push_back(look.along_m - way.along_m(look.time_s));
  return std::abs(median(std::move(off_m))) < kInLength_m &&
         std::abs(middle(looks, &Look::lateral_m) - lateral_m) < kInWidth_m;
}

}  // namespace

bool goes_on(const Vehicle& lost, const Vehicle& found, const RoadView& view) {
  constexpr std::size_t kFewest = 8;
  constexpr double kLast_s = 1.5, kAll_s = std::numeric_limits<double>::infinity();
  constexpr double kSigmas = 3.0, kFloor_m = 0.5, kFloorShare = 0.03;
  // Nearer to one another no vehicles follow, or drive in two lanes.
  constexpr double kMostOff_m = 5.0, kMostBeside_m = 1.2;
  if (lost.kind != found.kind) return false;
  const std::vector<Look> before = last_looks(lost, view, kLast_s),
                          looks = last_looks(found, view, kAll_s);
  if (before.size() < kFewest) return false;

  const Way way(before);
  const double lateral_m = middle(before, &Look::lateral_m);
  const auto after = std::ranges::upper_bound(looks, before.back().time_s, {}, &Look::time_s);
  if (after == looks.end()) return false;
  const auto beside = std::ranges::lower_bound(looks, before.front().time_s, {}, &Look::time_s);
  if (beside != after && (lost.second_on_body > 0 || found.second_on_body > 0 ||
                          !in_its_place({beside, after}, way, lateral_m)))
    return false;
  const std::span<const Look> later(after, looks.end());
  const double time_s = mean(later, &Look::time_s);
  const double off_m = mean(later, &Look::along_m) - way.along_m(time_s);
  const double sigma_m =
      way.sigma_m(time_s) + std::hypot(kFloor_m, kFloorShare * mean(later, &Look::depth_m));
  const double beside_m = middle(later, &Look::lateral_m) - lateral_m;
  return std::abs(off_m) < std::min(kMostOff_m, kSigmas * sigma_m) &&
         std::abs(beside_m) < kMostBeside_m;
}

void resume(const Vehicle& lost, Vehicle& found) {
  found.past_left = records_of(lost, nullptr, lost.past_left);
  found.past_right = records_of(lost, nullptr, lost.past_right);
  found.both_seen += lost.both_seen;
  found.second_on_body += lost.second_on_body;
  found.images += lost.images;
  found.ambiguous |= lost.ambiguous;
  found.told_strength |= lost.told_strength;
}

}  // namespace vildar
