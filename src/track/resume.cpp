#include "track/resume.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace vildar {
namespace {

struct Look {
  double time_s, along_m, lateral_m, depth_m;
};

// The last so many at both lamps, in order of time.
std::vector<Look> last_looks(const Vehicle& vehicle, const RoadView& view, std::size_t most) {
  const std::vector<LampRecord> left = records_of(vehicle, vehicle.left, vehicle.past_left);
  const std::vector<LampRecord> right = records_of(vehicle, vehicle.right, vehicle.past_right);
  std::vector<Look> looks;
  for (auto one = left.rbegin(), other = right.rbegin();
       one != left.rend() && other != right.rend() && looks.size() < most;) {
    const std::int64_t frame = std::max(one->frame, other->frame);
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

}  // namespace

bool goes_on(const Vehicle& lost, const Vehicle& found, const RoadView& view) {
  constexpr std::size_t kFewest = 8, kMost = 20, kAll = std::numeric_limits<std::size_t>::max();
  constexpr double kSigmas = 3.0, kFloor_m = 0.5, kFloorShare = 0.03;
  // Nearer to one another no vehicles follow, or drive in two lanes.
  constexpr double kMostOff_m = 5.0, kMostBeside_m = 1.2;
  if (lost.kind != found.kind) return false;
  const std::vector<Look> before = last_looks(lost, view, kMost),
                          after = last_looks(found, view, kAll);
  if (before.size() < kFewest || after.empty()) return false;
  if (after.front().time_s <= before.back().time_s) return false;

  const double time_s = mean(before, &Look::time_s), along_m = mean(before, &Look::along_m);
  double stt = 0.0, sta = 0.0, saa = 0.0;
  for (const Look& look : before) {
    stt += (look.time_s - time_s) * (look.time_s - time_s);
    sta += (look.time_s - time_s) * (look.along_m - along_m);
    saa += (look.along_m - along_m) * (look.along_m - along_m);
  }
  const double speed_mps = sta / stt;
  const double n = static_cast<double>(before.size());
  const double scatter_m2 = std::max(0.0, saa - speed_mps * sta) / (n - 2.0);
  const double ahead_s = mean(after, &Look::time_s) - time_s;
  const double off_m = mean(after, &Look::along_m) - (along_m + speed_mps * ahead_s);
  const double sigma_m = std::sqrt(scatter_m2 * (1.0 / n + ahead_s * ahead_s / stt)) +
                         std::hypot(kFloor_m, kFloorShare * mean(after, &Look::depth_m));
  const double beside_m = mean(after, &Look::lateral_m) - mean(before, &Look::lateral_m);
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
