#include "track/heir.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vildar {
namespace {

using Records = std::vector<LampRecord>;

// The first record from `frame` on.
Records::const_iterator from(const Records& records, std::int64_t frame) {
  return std::ranges::lower_bound(records, frame, {}, &LampRecord::frame);
}

}  // namespace

std::optional<double> came_out_of(const Lamp& younger, const Lamp& older) {
  constexpr double kUnresolved_px = 8.0, kShareOfWidth = 1.3;
  const LampRecord& birth = younger.records.front();
  const auto then = from(older.records, birth.frame);
  if (then == older.records.begin() || then == older.records.end()) return std::nullopt;
  const double apart_px = (then->at_px - birth.at_px).norm();
  const PixelBox& box = (then - 1)->sighting.box;
  if (apart_px > std::max(kUnresolved_px, kShareOfWidth * (box.u_max - box.u_min + 1.0)))
    return std::nullopt;
  return apart_px;
}

bool hand_over(Vehicle& vehicle, const Lamp& kept, Lamp& heir) {
  constexpr double kMostStretch = 1.5;
  Lamp* old = vehicle.partner_of(&kept);
  if (!old || heir.vehicle) return false;
  const auto apart_px = came_out_of(heir, *old);
  if (!apart_px) return false;
  const std::int64_t birth = heir.records.front().frame;
  const auto kept_then = from(kept.records, birth), old_then = from(old->records, birth);
  if (kept_then == kept.records.begin() || kept_then == kept.records.end()) return false;
  const double before_px = (old_then - 1)->at_px.x() - (kept_then - 1)->at_px.x();
  const double after_px = heir.records.front().at_px.x() - kept_then->at_px.x();
  const double stretch = after_px / before_px;
  const double now_px = heir.at_px().x() - kept.at_px().x();
  if (!(stretch > 1.0 / kMostStretch && stretch < kMostStretch && now_px * before_px > 0.0))
    return false;

  auto& past = vehicle.left == old ? vehicle.past_left : vehicle.past_right;
  const auto shared = static_cast<std::ptrdiff_t>(past.size());
  past.insert(past.end(), old->records.cbegin(), old_then);
  for (auto one = past.begin() + shared; one != past.end(); ++one) one->beside_px = *apart_px;
  (vehicle.left == old ? vehicle.left : vehicle.right) = &heir;
  heir.vehicle = &vehicle;
  old->leave_to_pair(old_then);
  old->vehicle = nullptr;
  return true;
}

void mark_split_records(Vehicle& vehicle) {
  if (vehicle.both_seen != 1 || !vehicle.left || !vehicle.right) return;
  if (!vehicle.past_left.empty() || !vehicle.past_right.empty()) return;
  Lamp* older = vehicle.left;
  Lamp* younger = vehicle.right;
  if (older->records.front().frame > younger->records.front().frame) std::swap(older, younger);
  const auto apart_px = came_out_of(*younger, *older);
  if (!apart_px) return;
  for (LampRecord& one : older->records) {
    if (one.frame >= younger->records.front().frame) break;
    one.merged_px = 0.5 * *apart_px;
  }
}

}  // namespace vildar
