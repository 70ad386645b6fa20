#include "track/own_lamp.h"

#include <algorithm>
#include <optional>

#include "track/lamp_way.h"

namespace vildar {
namespace {

using Records = std::vector<LampRecord>;

bool fit(const LampRecord& one, const LampRecord& other, const RoadView& view) {
  constexpr double kMostChi2 = 15.0;
  return one.merged_px == 0.0 && other.merged_px == 0.0 &&
         view.fit_pair(one.at_px, other.at_px, 1.0).chi2 < kMostChi2;
}

std::vector<PairPlace> good_pairs(const Records& left, const Records& right, const RoadView& view) {
  std::vector<PairPlace> pairs;
  for (auto one = left.begin(), other = right.begin(); one != left.end() && other != right.end();) {
    const std::int64_t frame = std::min(one->frame, other->frame);
    if (one->frame == other->frame && fit(*one, *other, view))
      pairs.push_back({seconds_of(one->time), one->at_px, other->at_px});
    one += one->frame == frame;
    other += other->frame == frame;
  }
  return pairs;
}

const LampRecord* in_frame(const Records& records, std::int64_t frame) {
  const auto found = std::ranges::lower_bound(records, frame, {}, &LampRecord::frame);
  return found != records.end() && found->frame == frame ? &*found : nullptr;
}

// Stands where the other lamp of the vehicle would; nothing unless one alone is seen of it.
std::optional<bool> completes(const LampRecord& light, const Records& left, const Records& right,
                              const RoadView& view) {
  const LampRecord* on_left = in_frame(left, light.frame);
  const LampRecord* on_right = in_frame(right, light.frame);
  if (!on_left == !on_right) return std::nullopt;
  const LampRecord& lamp = on_left ? *on_left : *on_right;
  const bool on_free_side = (light.at_px.x() > lamp.at_px.x()) == (on_left != nullptr);
  return on_free_side && fit(light, lamp, view);
}

// Where the lamps were, from the pairs before and after, or from 0.7 s before the first one.
std::optional<PairPlace> pair_at(double time_s, const std::vector<PairPlace>& pairs,
                                 const LampWay& way) {
  constexpr double kLongestGap_s = 1.7, kLongestBefore_s = 0.7;
  const auto after = std::ranges::lower_bound(pairs, time_s, {}, &PairPlace::time_s);
  if (after == pairs.end()) return std::nullopt;
  if (after == pairs.begin()) {
    const auto place = way.at(time_s);
    if (!place || after->time_s - time_s >= kLongestBefore_s) return std::nullopt;
    return PairPlace{time_s, place->left_px, place->right_px};
  }
  const PairPlace& before = *(after - 1);
  const double gap_s = after->time_s - before.time_s;
  if (gap_s > kLongestGap_s) return std::nullopt;
  const double share = (time_s - before.time_s) / gap_s;
  return PairPlace{time_s, before.left_px + share * (after->left_px - before.left_px),
                   before.right_px + share * (after->right_px - before.right_px)};
}

bool on_a_lamp(const Eigen::Vector2d& at_px, const PairPlace& pair) {
  constexpr double kNear_px = 2.0, kNearShare = 0.25;
  const double near_px = std::max(kNear_px, kNearShare * (pair.right_px - pair.left_px).norm());
  return std::min((at_px - pair.left_px).norm(), (at_px - pair.right_px).norm()) < near_px;
}

}  // namespace

bool was_lamp_of(const Lamp& light, const Vehicle& vehicle, const RoadView& view) {
  const Records left = records_of(vehicle, vehicle.left, vehicle.past_left);
  const Records right = records_of(vehicle, vehicle.right, vehicle.past_right);
  const std::vector<PairPlace> pairs = good_pairs(left, right, view);
  if (pairs.empty()) return false;
  const LampWay way(pairs, view);
  std::size_t on_lamp = 0, told = 0;
  for (const LampRecord& record : light.records) {
    std::optional<bool> is_lamp = completes(record, left, right, view);
    if (!is_lamp.value_or(false))
      if (const auto pair = pair_at(seconds_of(record.time), pairs, way))
        is_lamp = on_a_lamp(record.at_px, *pair);
    told += is_lamp.has_value();
    on_lamp += is_lamp.value_or(false);
  }
  return 2 * on_lamp > told && 2 * told > light.records.size();
}

}  // namespace vildar
