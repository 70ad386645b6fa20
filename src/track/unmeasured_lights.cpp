#include "track/unmeasured_lights.h"

#include <algorithm>
#include <span>
#include <vector>

#include "core/median.h"
#include "track/lone_light.h"

namespace vildar {
namespace {

// By how much its outline is wider in the last third of its looks than in the first.
double grown(std::span<const LampRecord> records) {
  const std::size_t third = std::max<std::size_t>(records.size() / 3, 1);
  const auto width_px = [](std::span<const LampRecord> part) {
    std::vector<double> widths_px;
    for (const LampRecord& record : part)
      widths_px.push_back(record.sighting.box.u_max - record.sighting.box.u_min + 1.0);
    return median(std::move(widths_px));
  };
  return width_px(records.last(third)) / width_px(records.first(third));
}

// One white area, for most of the time wider than a lamp is and mostly clipped, that comes or goes:
// the glare of all lamps of a vehicle.
bool clips_as_one(const Lamp& light, const RoadView& view) {
  constexpr double kNearer = 1.3, kShare = 0.8, kClippedShare = 0.5, kLong_s = 0.5;
  if (light.records.empty() || light.lived_s() < kLong_s) return false;
  const double nearer = grown(light.records);
  if (nearer < kNearer && nearer > 1.0 / kNearer) return false;
  const auto clipped = std::ranges::count_if(light.records, [&](const LampRecord& record) {
    const PixelBox& box = record.sighting.box;
    const double area_px = (box.u_max - box.u_min + 1.0) * (box.v_max - box.v_min + 1.0);
    return record.sighting.saturated_px > kClippedShare * area_px &&
           wider_than_a_lamp(record, view.place(record.at_px).inverse_depth_per_m, view);
  });
  return static_cast<double>(clipped) > kShare * static_cast<double>(light.records.size());
}

}  // namespace

void count_unmeasured(const Lamp& light, Verdict verdict, const RoadView& view,
                      TrackCounts& counts) {
  if (verdict == Verdict::vehicle || verdict == Verdict::reflection) return;
  counts.moving_lights += moves_plainly(light, view);
  counts.saturated += verdict == Verdict::undecided && clips_as_one(light, view);
}

}  // namespace vildar
