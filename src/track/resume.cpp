#include "track/resume.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>
#include <utility>

#include "core/median.h"
#include "track/vehicle_course.h"

namespace vildar {
namespace {

std::vector<LampLook> looks_at(const Vehicle& vehicle) {
  return looks_of(records_of(vehicle, vehicle.left, vehicle.past_left),
                  records_of(vehicle, vehicle.right, vehicle.past_right));
}

bool both_seen(const LampLook& look) { return look.left_px && look.right_px; }

// Two vehicles do not stand in one place: what was seen there was the same lamps.
bool in_its_place(std::span<const LampLook> looks, const VehicleCourse& course,
                  const RoadView& view) {
  constexpr double kInLength_m = 3.0, kInWidth_m = 0.7;
  std::vector<double> along_m, beside_m;
  for (const LampLook& look : looks) {
    if (!both_seen(look)) continue;
    const auto at = place_of(look, view);
    if (!at) continue;
    along_m.push_back(at->along_m - course.along_m(look.time_s));
    beside_m.push_back(at->lateral_m - course.lateral_m());
  }
  return !along_m.empty() && std::abs(median(std::move(along_m))) < kInLength_m &&
         std::abs(median(std::move(beside_m))) < kInWidth_m;
}

constexpr double kLast_s = 1.5, kFirst_s = 0.7;

std::span<const LampLook> last_part(std::span<const LampLook> looks) {
  const auto first =
      std::ranges::lower_bound(looks, looks.back().time_s - kLast_s, {}, &LampLook::time_s);
  return {first, looks.end()};
}

// Whether what was found is where the lost one would have got to.
bool would_be(const VehicleCourse& lost, std::span<const LampLook> found, const RoadView& view) {
  constexpr double kSigmas = 3.0, kFloor_m = 0.5, kFloorShare = 0.03;
  // Nearer to one another no vehicles follow, or drive in two lanes.
  constexpr double kMostOff_m = 5.0, kMostBeside_m = 1.0;
  // What is known no better than this tells nothing. Before a dashcam a queue shows but some of its
  // vehicles, and the next one may be the one behind.
  const double most_sigma_m = view.moving_sensor() ? 5.0 : 15.0;
  const auto enough =
      std::ranges::lower_bound(found, found.front().time_s + kFirst_s, {}, &LampLook::time_s);
  const auto later = lost.placed({found.begin(), enough}, view);
  if (!later) return false;
  const double time_s = later->time_s();
  const double off_m =
      later->along_m(time_s) - lost.along_m(time_s) + view.speeding_up_m(lost.time_s(), time_s);
  const double known_m = std::hypot(lost.along_sigma_m(time_s), later->along_sigma_m(time_s));
  const double sigma_m = known_m + std::hypot(kFloor_m, kFloorShare * later->along_m(time_s));
  return known_m < most_sigma_m && std::abs(off_m) < std::min(kMostOff_m, kSigmas * sigma_m) &&
         std::abs(later->lateral_m() - lost.lateral_m()) < kMostBeside_m;
}

}  // namespace

bool goes_on(const Vehicle& lost, const Vehicle& found, const RoadView& view) {
  if (lost.kind != found.kind) return false;
  const std::vector<LampLook> all = looks_at(lost), looks = looks_at(found);
  // A lamp seen alone to the last, or first, may be another one's.
  const auto last = std::ranges::find_if(all.rbegin(), all.rend(), both_seen).base();
  if (last == all.begin()) return false;
  const std::span<const LampLook> before = last_part({all.begin(), last});
  const auto after = std::ranges::upper_bound(looks, before.back().time_s, {}, &LampLook::time_s);
  const auto pair = std::find_if(after, looks.end(), both_seen);
  if (pair == looks.end()) return false;
  const auto course = VehicleCourse::of(before, view);
  if (!course) return false;
  const std::span<const LampLook> together(
      std::ranges::lower_bound(looks, before.front().time_s, {}, &LampLook::time_s), after);
  if (std::ranges::any_of(together, both_seen) &&
      (lost.second_on_body > 0 || found.second_on_body > 0 ||
       !in_its_place(together, *course, view)))
    return false;
  return would_be(*course, {pair, looks.end()}, view);
}

bool goes_on(const std::vector<LampRecord>& lost, const std::vector<LampRecord>& found,
             const RoadView& view) {
  const std::vector<LampLook> all = looks_of(lost, {}), looks = looks_of(found, {});
  if (all.empty() || looks.empty()) return false;
  const double hidden_s = looks.front().time_s - all.back().time_s;
  if (!(hidden_s > 0.0 && hidden_s < kLongestWait_s)) return false;
  const auto course = VehicleCourse::of(last_part(all), view);
  return course && would_be(*course, looks, view);
}

void resume(const Vehicle& lost, Vehicle& found) {
  found.past_left = records_of(lost, nullptr, lost.past_left);
  found.past_right = records_of(lost, nullptr, lost.past_right);
  found.both_seen += lost.both_seen;
  found.second_on_body += lost.second_on_body;
  found.in_row += lost.in_row;
  found.looks += lost.looks;
  found.images += lost.images;
  found.ambiguous |= lost.ambiguous;
  found.told_strength |= lost.told_strength;
}

void resume_lost(Vehicles& vehicles, Vehicles& waiting, std::int64_t frame,
                 std::int64_t waits_since, const RoadView& view) {
  constexpr unsigned kLately = 16;  // frames
  for (const auto& vehicle : vehicles) {
    const auto seen = static_cast<unsigned>(vehicle->both_seen);
    const bool is_new = seen <= kLately && std::has_single_bit(seen);
    if (!(is_new || vehicle->asked < waits_since) || vehicle->last_both != frame ||
        vehicle->cut_after || !vehicle->past_left.empty() || !vehicle->past_right.empty())
      continue;
    vehicle->asked = frame;
    std::vector<Vehicle*> hidden;
    for (const auto& other : vehicles)
      if (other->last_both < frame && !other->cut_after && goes_on(*other, *vehicle, view))
        hidden.push_back(other.get());
    std::vector<Vehicles::iterator> lost;
    for (auto one = waiting.begin(); one != waiting.end(); ++one)
      if (goes_on(**one, *vehicle, view)) lost.push_back(one);
    if (hidden.size() + lost.size() != 1) continue;
    if (lost.empty()) {
      hidden.front()->cut_after = hidden.front()->last_both;
    } else {
      resume(**lost.front(), *vehicle);
      waiting.erase(lost.front());
    }
  }
}

}  // namespace vildar
