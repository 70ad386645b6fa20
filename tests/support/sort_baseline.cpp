#include "support/sort_baseline.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <Eigen/LU>

#include "track/assignment.h"

namespace vildar {
namespace {

struct Detection {
  Eigen::Vector2d middle_px;
  double width_px = 0.0;
  LampPixels lamps;
};

double overlap(const Eigen::Vector2d& a_px, double a_width_px, const Eigen::Vector2d& b_px,
               double b_width_px) {
  const Eigen::Array2d reach = (a_px - b_px).array().abs();
  const Eigen::Array2d common =
      (0.5 * (a_width_px + b_width_px) - reach).min(std::min(a_width_px, b_width_px)).max(0.0);
  const double area = common.prod();
  return area / (a_width_px * a_width_px + b_width_px * b_width_px - area);
}

std::vector<Detection> detections_of(const BlobFrame& frame, const RoadView& view) {
  constexpr double kMostChi2 = 9.0, kSigma_px = 1.0, kWidths = 1.4;
  struct Mark {
    const Blob* blob;
    Eigen::Vector2d at_px;
  };
  struct Pair {
    double chi2;
    std::size_t a, b;
  };
  std::vector<Mark> marks;
  for (const Blob& blob : frame.blobs)
    if (blob.kind == LampKind::headlamp || blob.kind == LampKind::taillamp)
      if (const auto at_px = view.spot_from_pixel(blob.centre_px)) marks.push_back({&blob, *at_px});
  std::vector<Pair> pairs;
  for (std::size_t a = 0; a < marks.size(); ++a)
    for (std::size_t b = a + 1; b < marks.size(); ++b)
      if (marks[a].blob->kind == marks[b].blob->kind) {
        const double chi2 = view.fit_pair(marks[a].at_px, marks[b].at_px, kSigma_px).chi2;
        if (chi2 < kMostChi2) pairs.push_back({chi2, a, b});
      }
  std::sort(pairs.begin(), pairs.end(),
            [](const Pair& one, const Pair& other) { return one.chi2 < other.chi2; });
  std::vector<char> used(marks.size(), 0);
  std::vector<Detection> found;
  const auto add = [&](const Blob& left, const Blob* right, double separation_px) {
    Detection& one = found.emplace_back();
    one.lamps.left_px = left.centre_px;
    if (right) one.lamps.right_px = right->centre_px;
    one.middle_px = one.lamps.middle_px();
    one.width_px = kWidths * separation_px;
  };
  for (const Pair& pair : pairs) {
    if (used[pair.a] || used[pair.b]) continue;
    used[pair.a] = used[pair.b] = 1;
    const Blob* left = marks[pair.a].blob;
    const Blob* right = marks[pair.b].blob;
    if (left->centre_px.x() > right->centre_px.x()) std::swap(left, right);
    add(*left, right, (left->centre_px - right->centre_px).norm());
  }
  for (std::size_t i = 0; i < marks.size(); ++i)
    if (!used[i])
      add(*marks[i].blob, nullptr,
          view.separation_m() * view.focal_px() * view.place(marks[i].at_px).inverse_depth_per_m);
  return found;
}

// State: centre, area, aspect and the rates of the first three, per frame.
struct Follower {
  using State = Eigen::Matrix<double, 7, 1>;
  using Covariance = Eigen::Matrix<double, 7, 7>;
  State state = State::Zero();
  Covariance covariance = Covariance::Identity();
  int unseen = 0, streak = 1;
  RunVehicle run;

  explicit Follower(const Detection& seen) {
    state << seen.middle_px, seen.width_px * seen.width_px, 1.0, 0.0, 0.0, 0.0;
    covariance.diagonal() << 10.0, 10.0, 10.0, 10.0, 1e4, 1e4, 1e4;
  }
  void predict() {
    if (state(2) + state(6) <= 0.0) state(6) = 0.0;
    Covariance step = Covariance::Identity();
    step(0, 4) = step(1, 5) = step(2, 6) = 1.0;
    state = (step * state).eval();
    covariance = (step * covariance * step.transpose()).eval();
    State noise;
    noise << 1.0, 1.0, 1.0, 1.0, 0.01, 0.01, 1e-4;
    covariance.diagonal() += noise;
    if (unseen > 0) streak = 0;
    ++unseen;
  }
  void update(const Detection& seen) {
    const Eigen::Vector4d measured(seen.middle_px.x(), seen.middle_px.y(),
                                   seen.width_px * seen.width_px, 1.0);
    Eigen::Matrix4d innovation = covariance.topLeftCorner<4, 4>();
    innovation.diagonal() += Eigen::Vector4d(1.0, 1.0, 10.0, 10.0);
    const Eigen::Matrix<double, 7, 4> gain = covariance.leftCols<4>() * innovation.inverse();
    state += gain * (measured - state.head<4>());
    covariance -= (gain * covariance.topRows<4>()).eval();
    unseen = 0;
    ++streak;
  }
  double width_px() const { return std::sqrt(std::max(state(2), 1.0)); }
};

}  // namespace

std::vector<RunVehicle> sort_baseline(const std::vector<BlobFrame>& frames, const RoadView& view,
                                      int max_age) {
  constexpr int kMinHits = 3;
  constexpr double kLeastOverlap = 0.3;
  std::vector<Follower> followed;
  std::vector<RunVehicle> done;
  const auto end = [&](Follower& one) {
    if (!one.run.sightings.empty()) done.push_back(std::move(one.run));
  };
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const std::vector<Detection> seen = detections_of(frames[k], view);
    for (Follower& one : followed) one.predict();
    Eigen::MatrixXd cost(std::ssize(followed), std::ssize(seen));
    for (std::size_t i = 0; i < followed.size(); ++i)
      for (std::size_t j = 0; j < seen.size(); ++j)
        cost(i, j) = -overlap(followed[i].state.head<2>(), followed[i].width_px(),
                              seen[j].middle_px, seen[j].width_px);
    const auto assigned = assign_rows(cost, -kLeastOverlap);
    std::vector<char> taken(seen.size(), 0);
    const auto note = [&](Follower& one, const Detection& detection) {
      if (one.streak >= kMinHits || k < static_cast<std::size_t>(kMinHits))
        one.run.sightings.push_back({frames[k].frame, detection.lamps, {}, {}});
    };
    for (std::size_t i = 0; i < assigned.size(); ++i) {
      if (!assigned[i]) continue;
      const auto j = static_cast<std::size_t>(*assigned[i]);
      taken[j] = 1;
      followed[i].update(seen[j]);
      note(followed[i], seen[j]);
    }
    for (std::size_t j = 0; j < seen.size(); ++j)
      if (!taken[j]) note(followed.emplace_back(seen[j]), seen[j]);
    for (Follower& one : followed)
      if (one.unseen > max_age) end(one);
    std::erase_if(followed, [&](const Follower& one) { return one.unseen > max_age; });
  }
  for (Follower& one : followed) end(one);
  for (std::size_t i = 0; i < done.size(); ++i) done[i].track_id = std::to_string(i + 1);
  return done;
}

}  // namespace vildar
