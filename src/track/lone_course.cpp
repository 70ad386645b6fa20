#include "track/lone_course.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <Eigen/QR>

namespace vildar {
namespace {

/// Looks beside the course of these.
Eigen::Index off_course(std::span<const LampRecord> records, const RoadView& view) {
  constexpr std::size_t kFewest = 8;
  constexpr double kMost = 0.6, kOff_px = 3.0;
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
  Eigen::ArrayXd off_px2;
  for (int round = 0; round < kRounds; ++round) {
    const auto left_over = [&](const auto& model, const Eigen::VectorXd& seen) {
      const Eigen::MatrixXd kept = model(nearest, Eigen::all);
      const Eigen::VectorXd fit = kept.colPivHouseholderQr().solve(seen(nearest));
      return (seen - model * fit).array().square().eval();
    };
    off_px2 = left_over(motion, along_px) + left_over(drift, across_px);
    nearest.resize(records.size());
    std::iota(nearest.begin(), nearest.end(), Eigen::Index{0});
    std::ranges::nth_element(nearest, nearest.begin() + static_cast<std::ptrdiff_t>(most), {},
                             [&](Eigen::Index i) { return off_px2[i]; });
    nearest.resize(most);
  }
  return (off_px2 > kOff_px * kOff_px).count();
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
