#include "track/lone_course.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <Eigen/QR>

namespace vildar {
namespace {

// Goes from side to side, beyond half its scatter, as a camera's shaking by 0.75 Hz or more does.
bool swings(const Eigen::ArrayXd& off_px, double seconds) {
  constexpr double kClear = 0.5, kLeast_px = 1.0, kLeastPerSecond = 1.5, kFewest = 4.0;
  const double clear_px = kClear * std::max(kLeast_px, std::sqrt(off_px.square().mean()));
  double side = 0.0, crossings = 0.0;
  for (const double one_px : off_px) {
    if (std::abs(one_px) < clear_px) continue;
    crossings += one_px * side < 0.0;
    side = one_px;
  }
  return crossings >= std::max(kFewest, kLeastPerSecond * seconds);
}

// Per axis, from the nearest three tenths, which hold though most look elsewhere.
double variance_of_nearest(const Eigen::ArrayXd& off_px2) {
  constexpr double kShare = 0.3;
  std::vector<double> sorted_px2(off_px2.begin(), off_px2.end());
  const auto nearest = sorted_px2.begin() +
                       static_cast<std::ptrdiff_t>(kShare * static_cast<double>(off_px2.size()));
  std::ranges::nth_element(sorted_px2, nearest);
  return *nearest / (-2.0 * std::log(1.0 - kShare));
}

/// Looks beside the course of these.
Eigen::Index off_course(std::span<const LampRecord> records, const RoadView& view) {
  constexpr std::size_t kFewest = 8;
  constexpr double kMost = 0.6, kOff_px = 3.0, kSigmas = 3.0, kFar = 0.05;
  constexpr int kRounds = 6;
  if (records.size() < kFewest) return 0;
  const auto count = static_cast<Eigen::Index>(records.size());
  Eigen::MatrixX3d motion(count, 3);
  Eigen::MatrixX2d drift(count, 2);
  Eigen::VectorXd along_px(count), across_px(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const LampRecord& record = records[static_cast<std::size_t>(i)];
    const LampPlace place = view.place(record.at_px);
    const RoadPosition at = view.road_at(record.at_px, place.inverse_depth_per_m);
    const double time_s = seconds_of(record.time) - seconds_of(records.front().time);
    const double along_px_per_m = place.inverse_depth_per_m * place.toward_px.norm();
    const double across_px_per_m = place.inverse_depth_per_m * place.across_px.norm();
    motion.row(i) = along_px_per_m * Eigen::RowVector3d(1.0, time_s, time_s * time_s);
    drift.row(i) = across_px_per_m * Eigen::RowVector2d(1.0, time_s);
    along_px[i] = along_px_per_m * at.along_m;
    across_px[i] = across_px_per_m * at.lateral_m;
  }
  // Least trimmed squares (Rousseeuw and Van Driessen 2006): fit, keep the nearest, fit again.
  std::vector<Eigen::Index> nearest(records.size());
  std::iota(nearest.begin(), nearest.end(), Eigen::Index{0});
  const auto most = static_cast<std::size_t>(kMost * static_cast<double>(records.size()));
  Eigen::ArrayXd along_off_px, across_off_px, off_px2;
  for (int round = 0; round < kRounds; ++round) {
    const auto left_over = [&](const auto& model, const Eigen::VectorXd& seen) {
      const Eigen::MatrixXd kept = model(nearest, Eigen::all);
      const Eigen::VectorXd fit = kept.colPivHouseholderQr().solve(seen(nearest));
      return (seen - model * fit).array().eval();
    };
    along_off_px = left_over(motion, along_px);
    across_off_px = left_over(drift, across_px);
    off_px2 = along_off_px.square() + across_off_px.square();
    nearest.resize(records.size());
    std::iota(nearest.begin(), nearest.end(), Eigen::Index{0});
    std::ranges::nth_element(nearest, nearest.begin() + static_cast<std::ptrdiff_t>(most), {},
                             [&](Eigen::Index i) { return off_px2[i]; });
    nearest.resize(most);
  }
  const auto beyond = [&](double least_px2) { return (off_px2 > least_px2).count(); };
  const Eigen::Index off = beyond(kOff_px * kOff_px);
  // A camera that shakes swings all looks to and fro, by no more than the nearest of them say.
  const double seconds = seconds_of(records.back().time) - seconds_of(records.front().time);
  const bool shaken =
      (swings(along_off_px, seconds) || swings(across_off_px, seconds)) &&
      static_cast<double>(beyond(kSigmas * kSigmas * variance_of_nearest(off_px2))) <=
          kFar * static_cast<double>(count);
  return shaken ? 0 : off;
}

}  // namespace

double off_course_share(std::span<const LampRecord> records, const RoadView& view) {
  constexpr double kStretch_s = 2.0;
  if (view.moving_sensor() || records.empty()) return 0.0;
  const double first_s = seconds_of(records.front().time);
  const double lived_s = seconds_of(records.back().time) - first_s;
  const double stretch_s = lived_s / std::max(1.0, std::floor(lived_s / kStretch_s));
  Eigen::Index off = 0;
  for (auto from = records.begin(); from != records.end();) {
    const double until_s = seconds_of(from->time) + stretch_s;
    const auto to = std::find_if(from, records.end(), [&](const LampRecord& record) {
      return seconds_of(record.time) > until_s;
    });
    off += off_course({from, to}, view);
    from = to;
  }
  return static_cast<double>(off) / static_cast<double>(records.size());
}

}  // namespace vildar
