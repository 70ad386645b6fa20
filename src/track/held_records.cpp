#include "track/held_records.h"

#include <algorithm>
#include <utility>

#include "track/vehicle.h"

namespace vildar {
namespace {

constexpr std::size_t kHeldFixed = 100;

// Twice as many may be held before the older half goes.
void keep_last(std::size_t most, std::vector<LampRecord>& records) {
  if (records.size() > 2 * most)
    records.erase(records.begin(), records.end() - static_cast<std::ptrdiff_t>(most));
}

bool stayed_at(const Eigen::Vector2d& at_px, const std::vector<LampRecord>& records) {
  return std::ranges::all_of(
      records, [&](const LampRecord& record) { return (record.at_px - at_px).norm() < kMoved_px; });
}

}  // namespace

void drop_old_records(const Lamps& lamps, const Vehicles& vehicles) {
  for (const auto& lamp : lamps)
    if (!lamp->vehicle) keep_last(lamp->fixed ? kHeldFixed : kHeldAlone, lamp->records);
  for (const auto& vehicle : vehicles) {
    if (!vehicle->left || !vehicle->right) continue;
    if (std::max(vehicle->left->wandered_px(), vehicle->right->wandered_px()) >= kMoved_px)
      continue;
    for (auto [lamp, past] : {std::pair(vehicle->left, &vehicle->past_left),
                              std::pair(vehicle->right, &vehicle->past_right)}) {
      if (lamp->records.size() > 2 * kHeldAlone && stayed_at(lamp->at_px(), *past)) past->clear();
      keep_last(kHeldAlone, lamp->records);
    }
  }
}

}  // namespace vildar
