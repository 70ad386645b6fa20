#include "track/own_lamp.h"

#include <algorithm>
#include <iterator>
#include <optional>

#include "core/by_frame.h"
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
  for_each_common_frame(left, right, &LampRecord::frame,
                        [&](const LampRecord& one, const LampRecord& other) {
                          if (fit(one, other, view))
                            pairs.push_back({seconds_of(one.time), one.at_px, other.at_px});
                        });
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

std::int64_t last_frame_of(const Vehicle& vehicle) {
  std::int64_t last = -1;
  for (const Records* past : {&vehicle.past_left, &vehicle.past_right})
    if (!past->empty()) last = std::max(last, past->back().frame);
  for (const Lamp* lamp : {vehicle.left, vehicle.right})
    if (lamp && !lamp->records.empty()) last = std::max(last, lamp->records.back().frame);
  return last;
}

/// What was seen of a vehicle, to tell its lamps by.
class Seen {
 public:
  Seen(const Vehicle& vehicle, const RoadView& view)
      : view_(view),
        left_(records_of(vehicle, vehicle.left, vehicle.past_left)),
        right_(records_of(vehicle, vehicle.right, vehicle.past_right)),
        pairs_(good_pairs(left_, right_, view)),
        way_(pairs_, view) {}
  const std::vector<PairPlace>& pairs() const { return pairs_; }
  const Records& left() const { return left_; }
  const Records& right() const { return right_; }
  // Both its lamps are other lights than any third one.
  bool shows_both(std::int64_t frame) const {
    const LampRecord *left = in_frame(left_, frame), *right = in_frame(right_, frame);
    return left && right && left->merged_px == 0.0 && right->merged_px == 0.0;
  }
  // Whether a light was one of its lamps then; nothing where that cannot be told.
  std::optional<bool> lamp_was(const LampRecord& light) const {
    std::optional<bool> is_lamp = completes(light, left_, right_, view_);
    if (!is_lamp.value_or(false))
      if (const auto pair = pair_at(seconds_of(light.time), pairs_, way_))
        is_lamp = on_a_lamp(light.at_px, *pair);
    return is_lamp;
  }

 private:
  const RoadView& view_;
  Records left_, right_;
  std::vector<PairPlace> pairs_;
  LampWay way_;
};

}  // namespace

bool was_lamp_of(const Lamp& light, const Vehicle& vehicle, const RoadView& view) {
  const Seen seen(vehicle, view);
  if (seen.pairs().empty()) return false;
  std::size_t on_lamp = 0, told = 0;
  for (const LampRecord& record : light.records) {
    const std::optional<bool> is_lamp = seen.lamp_was(record);
    told += is_lamp.has_value();
    on_lamp += is_lamp.value_or(false);
  }
  return 2 * on_lamp > told && 2 * told > light.records.size();
}

std::optional<std::int64_t> last_frame_as_another(const Vehicle& vehicle,
                                                  const std::vector<const Vehicle*>& others,
                                                  const RoadView& view) {
  const Seen own(vehicle, view);
  if (own.pairs().empty()) return std::nullopt;
  const double first_pair_s = own.pairs().front().time_s;
  std::vector<LampRecord> alone;
  for (const Records* records : {&own.left(), &own.right()})
    std::ranges::copy_if(*records, std::back_inserter(alone), [&](const LampRecord& record) {
      return seconds_of(record.time) < first_pair_s;
    });
  if (alone.empty()) return std::nullopt;
  const std::int64_t first = std::ranges::min(alone, {}, &LampRecord::frame).frame;
  std::optional<std::int64_t> last;
  for (const Vehicle* other : others) {
    if (last_frame_of(*other) < first) continue;
    const Seen known(*other, view);
    if (known.pairs().empty() || known.pairs().front().time_s >= first_pair_s) continue;
    for (const LampRecord& record : alone)
      if (!known.shows_both(record.frame) && known.lamp_was(record).value_or(false))
        last = std::max(last, {record.frame});
  }
  return last;
}

}  // namespace vildar
