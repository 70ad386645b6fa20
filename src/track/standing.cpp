#include "track/standing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace vildar {
namespace {

constexpr double kMostShake_rad = 0.05, kMostSway_rad = 0.1;

// Goes to and fro, as a light does before a camera that shakes, and gets nowhere.
bool gets_nowhere(const Lamp& lamp, const RoadView& view, double most_rad) {
  constexpr std::size_t kMostRecords = 200;
  constexpr double kNowhere = 0.2;  // steady motion: 0.5
  const std::size_t count = std::min(kMostRecords, lamp.records.size()) & ~std::size_t{1};
  if (count == 0) return false;
  const auto first = lamp.records.end() - static_cast<std::ptrdiff_t>(count);
  const auto half = first + static_cast<std::ptrdiff_t>(count / 2);
  Eigen::Vector2d gone_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d least_px = first->at_px, most_px = first->at_px;
  for (auto record = first; record != lamp.records.end(); ++record) {
    gone_px += (record < half ? -2.0 : 2.0) / static_cast<double>(count) * record->at_px;
    least_px = least_px.cwiseMin(record->at_px);
    most_px = most_px.cwiseMax(record->at_px);
  }
  const double extent_px = (most_px - least_px).norm();
  return extent_px < most_rad * view.focal_px() && gone_px.norm() < kNowhere * extent_px;
}

const LampRecord* record_in(const Lamp& lamp, std::int64_t frame) {
  const auto at = std::ranges::lower_bound(lamp.records, frame, {}, &LampRecord::frame);
  return at != lamp.records.end() && at->frame == frame ? &*at : nullptr;
}

double angle_rad(const Eigen::Vector2d& one_px, const Eigen::Vector2d& other_px, double focal_px) {
  const Eigen::Vector3d one(one_px.x(), one_px.y(), focal_px);
  const Eigen::Vector3d other(other_px.x(), other_px.y(), focal_px);
  return std::atan2(one.cross(other).norm(), one.dot(other));
}

// Looks at a lamp over its last seconds, the newest first; none where it has not been seen so long
// or has gone farther than a camera that sways makes it go.
constexpr std::size_t kLooks = 5;
using Looks = std::array<const LampRecord*, kLooks>;
std::optional<Looks> looks_at(const Lamp& lamp, const RoadView& view) {
  constexpr double kShortest_s = 2.0, kLongest_s = 4.0;
  const LampRecord& newest = lamp.records.back();
  const double now_s = seconds_of(newest.time);
  const double span_s = std::min(kLongest_s, now_s - seconds_of(lamp.records.front().time));
  if (span_s < kShortest_s) return std::nullopt;
  Looks looks{&newest};
  for (std::size_t k = 1; k < kLooks; ++k) {
    const double at_s = now_s - span_s * static_cast<double>(k) / (kLooks - 1);
    const auto record = std::ranges::lower_bound(
        lamp.records, at_s, {}, [](const LampRecord& one) { return seconds_of(one.time); });
    looks[k] = &*record;
    if (angle_rad(record->at_px, newest.at_px, view.focal_px()) > kMostSway_rad)
      return std::nullopt;
  }
  return looks;
}

bool keeps_its_angle(const Looks& looks, const Lamp& to, const RoadView& view) {
  constexpr double kApart_rad = 0.04, kScatter_px = 1.0, kOfAngle = 0.003;
  double now_rad = 0.0;
  for (const LampRecord* look : looks) {
    const LampRecord* other = record_in(to, look->frame);
    if (!other) return false;
    const double apart_rad = angle_rad(look->at_px, other->at_px, view.focal_px());
    if (look == looks.front()) now_rad = apart_rad;
    if (now_rad < kApart_rad ||
        std::abs(apart_rad - now_rad) > std::max(kScatter_px / view.focal_px(), kOfAngle * now_rad))
      return false;
  }
  return true;
}

}  // namespace

void Sway::see(const CommonShift& shift) {
  constexpr double kNewest = 0.005, kOften = 0.0125, kSeldom = 0.0005;
  share_ += kNewest * ((shift.of_all ? 1.0 : 0.0) - share_);
  told_ = share_ > (told_ ? kSeldom : kOften);
}

bool stands_in_the_world(const Lamp& lamp, const Lamps& lamps, const RoadView& view, bool sways) {
  constexpr double kLongEnough_s = 1.0, kStill_px = 5.0, kStill_m = 1.0;
  if (view.moving_sensor() || lamp.lived_s() < kLongEnough_s) return false;
  const double metre_px = lamp.place().inverse_depth_per_m * lamp.place().toward_px.norm();
  if (lamp.wandered_px() < std::max(kStill_px, kStill_m * metre_px) ||
      gets_nowhere(lamp, view, sways ? kMostSway_rad : kMostShake_rad))
    return true;
  if (lamp.vehicle || !sways) return false;
  const auto looks = looks_at(lamp, view);
  return looks && std::ranges::any_of(lamps, [&](const auto& other) {
           return other.get() != &lamp && !other->vehicle && keeps_its_angle(*looks, *other, view);
         });
}

Lamp steadied(const Lamp& lamp, const Attitude& attitude, const RoadView& view) {
  Lamp steady = lamp;
  for (LampRecord& record : steady.records)
    if (const auto turn = attitude.at(record.frame))
      record.at_px = view.focal_px() * rotated(record.at_px / view.focal_px(), turn->rotation_rad);
  return steady;
}

}  // namespace vildar
