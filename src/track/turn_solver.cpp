#include "track/turn_solver.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "track/light_place.h"
#include "types/camera_turn.h"

namespace vildar {
namespace {

using Eigen::Index;

// Before anything is seen, one sigma.
const Eigen::Vector3d kFirstTurn_rad(0.01, 0.01, 0.003);
constexpr double kDrift_radps = 0.01;  // of the heading beside what the camera's way says
constexpr double kLeastPose_rad = 0.002;
constexpr Index kShared = 4;  // mean pose and drift
constexpr std::size_t kFewestSightings = 8;
using SharedEffect = Eigen::Matrix<double, 2, kShared>;

Eigen::Matrix3d about_up(double rad) {
  return Eigen::AngleAxisd(rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

class Fit {
 public:
  explicit Fit(const TurnProblem& problem);

  bool any() const { return !lights_.empty(); }
  void descend();
  TurnSolution solution() const;

 private:
  struct Sighting {
    PassedView view;
    std::size_t light;
    double sigma, after_s;  ///< after the middle of all
  };
  struct Light {
    LightPlace place;
    double variance = 0.0;  ///< of what its place leaves, per axis
  };
  struct Frame {
    std::vector<Sighting> seen;
    Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
    // Its share of the normal equations: the turn's own, and with the unknowns in `columns`.
    Eigen::Matrix3d information;
    Eigen::Vector3d right;
    std::vector<Index> columns;
    Eigen::Matrix3Xd coupling;
  };
  /// A sighting against what is expected.
  struct Look {
    ExpectedView expected;
    Eigen::Matrix<double, 2, 3> by_turn;
    SharedEffect by_shared;
    Eigen::Vector2d left;
    double weight;
  };

  Index shared_from() const { return 3 * static_cast<Index>(lights_.size()); }
  std::optional<Look> look(const Frame& frame, const Sighting& seen) const;
  void step();
  void eliminate_turn(Frame& frame, Eigen::MatrixXd& information, Eigen::VectorXd& right) const;
  void follow_scatter();
  void follow_turns();
  Eigen::Array3d crossings() const;
  Eigen::Array3d slowness() const;

  const Eigen::Matrix3d camera_from_road_;
  Eigen::Vector4d shared_std_;
  Eigen::Vector4d shared_ = Eigen::Vector4d::Zero();
  std::vector<Light> lights_;
  std::vector<Frame> frames_;
  double lit_frames_ = 0.0;
  Eigen::Vector3d turn_variance_ = kFirstTurn_rad.cwiseAbs2();
  Eigen::MatrixXd covariance_;  ///< of places and shared unknowns
};

Fit::Fit(const TurnProblem& problem)
    : camera_from_road_(problem.camera_from_road), frames_(problem.frames) {
  shared_std_ << problem.pose_std_rad.cwiseMax(kLeastPose_rad), kDrift_radps;
  std::vector<std::vector<const PassedLight*>> of_light(problem.lights);
  for (const PassedLight& seen : problem.sightings) of_light[seen.light].push_back(&seen);
  std::erase_if(of_light, [](const auto& seen) { return seen.size() < kFewestSightings; });
  double sum_s = 0.0, count = 0.0;
  for (const auto& seen : of_light)
    for (const PassedLight* one : seen) {
      sum_s += one->time_s;
      count += 1.0;
    }
  for (const auto& seen : of_light) {
    const PassedLight& reference = *seen[seen.size() / 2];
    std::vector<PassedView> views;
    for (const PassedLight* one : seen) {
      const Eigen::Vector2d back_m = reference.camera_m - one->camera_m;
      PassedView view;
      view.turned = camera_from_road_ * about_up(reference.heading_rad - one->heading_rad) *
                    camera_from_road_.transpose();
      view.moved_m = camera_from_road_ * about_up(-one->heading_rad) *
                     Eigen::Vector3d(back_m.x(), back_m.y(), 0.0);
      view.at = one->at;
      frames_[one->frame].seen.push_back(
          {view, lights_.size(), one->sigma, one->time_s - sum_s / count});
      views.push_back(view);
    }
    lights_.push_back({first_place(views, reference.at, kFirstTurn_rad[0])});
  }
  for (const Frame& frame : frames_) lit_frames_ += !frame.seen.empty();
}

std::optional<Fit::Look> Fit::look(const Frame& frame, const Sighting& seen) const {
  constexpr double kHuber = 2.0;
  const Light& light = lights_[seen.light];
  const auto expected = expected_view(seen.view, light.place);
  if (!expected) return std::nullopt;
  Look found;
  found.expected = *expected;
  found.by_turn = turn_effect(expected->at);
  found.by_shared << found.by_turn, found.by_turn * camera_from_road_.col(2) * seen.after_s;
  found.left =
      seen.view.at - expected->at - found.by_shared * shared_ - found.by_turn * frame.turn_rad;
  const double variance = std::max(seen.sigma * seen.sigma, light.variance);
  const double far = found.left.norm() / std::sqrt(2.0 * variance);
  found.weight = (far < kHuber ? 1.0 : kHuber / far) / variance;
  return found;
}

// Adds what a frame tells of places and shared unknowns once its own turn is free to follow.
void Fit::eliminate_turn(Frame& frame, Eigen::MatrixXd& information, Eigen::VectorXd& right) const {
  frame.information = turn_variance_.cwiseInverse().asDiagonal();
  frame.right = -frame.information * frame.turn_rad;
  frame.columns.clear();
  frame.coupling.setZero(3, 3 * static_cast<Index>(frame.seen.size()) + kShared);
  for (std::size_t i = 0; i < frame.seen.size(); ++i) {
    const Index first = 3 * static_cast<Index>(frame.seen[i].light);
    for (Index k = 0; k < 3; ++k) frame.columns.push_back(first + k);
    const auto seen = look(frame, frame.seen[i]);
    if (!seen) continue;
    const auto& [expected, by_turn, by_shared, left, weight] = *seen;
    frame.information += weight * by_turn.transpose() * by_turn;
    frame.right += weight * by_turn.transpose() * left;
    frame.coupling.middleCols<3>(3 * static_cast<Index>(i)) +=
        weight * by_turn.transpose() * expected.by_place;
    frame.coupling.rightCols<kShared>() += weight * by_turn.transpose() * by_shared;
    const Eigen::Matrix<double, 3, kShared> cross =
        weight * expected.by_place.transpose() * by_shared;
    information.block<3, 3>(first, first) +=
        weight * expected.by_place.transpose() * expected.by_place;
    information.block<3, kShared>(first, shared_from()) += cross;
    information.block<kShared, 3>(shared_from(), first) += cross.transpose();
    information.bottomRightCorner<kShared, kShared>() += weight * by_shared.transpose() * by_shared;
    right.segment<3>(first) += weight * expected.by_place.transpose() * left;
    right.tail<kShared>() += weight * by_shared.transpose() * left;
  }
  for (Index k = 0; k < kShared; ++k) frame.columns.push_back(shared_from() + k);
  const Eigen::Matrix3Xd response = frame.information.inverse() * frame.coupling;
  information(frame.columns, frame.columns) -= frame.coupling.transpose() * response;
  right(frame.columns) -= response.transpose() * frame.right;
}

void Fit::step() {
  const Index unknowns = shared_from() + kShared;
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(unknowns, unknowns);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(unknowns);
  constexpr double kDistancePrior = 1.0 / (kInverseDistance_per_m * kInverseDistance_per_m);
  for (std::size_t light = 0; light < lights_.size(); ++light) {
    const Index at = 3 * static_cast<Index>(light) + 2;
    information(at, at) = kDistancePrior;
    right[at] = -kDistancePrior * lights_[light].place.z();
  }
  const Eigen::Vector4d shared_prior = shared_std_.cwiseAbs2().cwiseInverse();
  information.diagonal().tail<kShared>() = shared_prior;
  right.tail<kShared>() = -shared_prior.cwiseProduct(shared_);
  for (Frame& frame : frames_) eliminate_turn(frame, information, right);
  // Scaled, for the unknowns differ by orders.
  const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<Eigen::MatrixXd> solver(scale.asDiagonal() * information * scale.asDiagonal());
  covariance_ = scale.asDiagonal() * solver.solve(Eigen::MatrixXd::Identity(unknowns, unknowns)) *
                scale.asDiagonal();
  const Eigen::VectorXd moved = covariance_ * right;
  for (std::size_t light = 0; light < lights_.size(); ++light)
    lights_[light].place += moved.segment<3>(3 * static_cast<Index>(light));
  shared_ += moved.tail<kShared>();
  for (Frame& frame : frames_)
    frame.turn_rad +=
        frame.information.inverse() * (frame.right - frame.coupling * moved(frame.columns));
}

// A light scatters about its place by more than its centres say, or is none that stands. What the
// turns take of the scatter is theirs.
void Fit::follow_scatter() {
  constexpr double kFewest = 3.0;
  Eigen::ArrayXd square = Eigen::ArrayXd::Zero(static_cast<Index>(lights_.size()));
  Eigen::ArrayXd freedom = square;
  for (const Frame& frame : frames_) {
    const Eigen::Matrix3d own = frame.information.inverse();
    for (const Sighting& seen : frame.seen) {
      const auto now = look(frame, seen);
      if (!now) continue;
      const double taken = now->weight * (now->by_turn * own * now->by_turn.transpose()).trace();
      square[static_cast<Index>(seen.light)] += now->left.squaredNorm();
      freedom[static_cast<Index>(seen.light)] += std::max(0.0, 2.0 - taken);
    }
  }
  for (std::size_t light = 0; light < lights_.size(); ++light) {
    const auto at = static_cast<Index>(light);
    if (freedom[at] > kFewest) lights_[light].variance = square[at] / freedom[at];
  }
}

void Fit::follow_turns() {
  constexpr double kLeast_rad = 1e-5;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Frame& frame : frames_)
    if (!frame.seen.empty())
      sum += frame.turn_rad.cwiseAbs2() + frame.information.inverse().diagonal();
  turn_variance_ = (sum / lit_frames_).cwiseMax(kLeast_rad * kLeast_rad);
}

Eigen::Array3d Fit::crossings() const {
  Eigen::Array3d mean_rad = Eigen::Array3d::Zero(), crossings = mean_rad;
  for (const Frame& frame : frames_)
    if (!frame.seen.empty()) mean_rad += frame.turn_rad.array() / lit_frames_;
  // From one side to the other, beyond half the movement; before the first such look, none.
  constexpr double kClear = 0.5;
  const Eigen::Array3d clear_rad = kClear * turn_variance_.array().sqrt();
  Eigen::Array3d side = Eigen::Array3d::Zero();
  for (const Frame& frame : frames_) {
    if (frame.seen.empty()) continue;
    const Eigen::Array3d off_rad = frame.turn_rad.array() - mean_rad;
    const Eigen::Array3d now = (off_rad.abs() > clear_rad).select(off_rad.sign(), side);
    crossings += (now * side < 0.0).cast<double>();
    side = now;
  }
  return crossings;
}

// Variance of the mean of the turns over that of as many independent ones.
Eigen::Array3d Fit::slowness() const {
  constexpr double kMostAlike = 0.95;
  Eigen::Array3d product = Eigen::Array3d::Zero(), square = product;
  for (std::size_t f = 1; f < frames_.size(); ++f) {
    const Frame &before = frames_[f - 1], &now = frames_[f];
    if (before.seen.empty() || now.seen.empty()) continue;
    product += before.turn_rad.array() * now.turn_rad.array();
    square += 0.5 * (before.turn_rad.array().square() + now.turn_rad.array().square());
  }
  const Eigen::Array3d alike = (product / square.max(1e-12)).max(0.0).min(kMostAlike);
  return (1.0 + alike) / (1.0 - alike);
}

void Fit::descend() {
  constexpr int kRounds = 8, kRoundsBeforeTurns = 2;
  for (int round = 0; round < kRounds; ++round) {
    step();
    follow_scatter();
    if (round >= kRoundsBeforeTurns) follow_turns();
  }
  // Turns much like their neighbours' tell places and mean pose apart from themselves less well.
  const Eigen::Vector3d variance = turn_variance_;
  turn_variance_.array() *= slowness();
  step();
  turn_variance_ = variance;
}

TurnSolution Fit::solution() const {
  TurnSolution found;
  found.std_rad = turn_variance_.cwiseSqrt();
  found.crossings = crossings();
  // How each turn follows places and shared unknowns; the mean of that is an error of all frames.
  const Index unknowns = shared_from() + kShared;
  std::vector<Eigen::Matrix3Xd> responses;
  Eigen::Matrix3Xd mean = Eigen::Matrix3Xd::Zero(3, unknowns);
  for (const Frame& frame : frames_) {
    responses.emplace_back(Eigen::Matrix3Xd::Zero(3, unknowns));
    if (frame.seen.empty()) continue;
    responses.back()(Eigen::all, frame.columns) = frame.information.inverse() * frame.coupling;
    mean += responses.back() / lit_frames_;
  }
  const Eigen::Array3d of_mean = turn_variance_.array() * slowness() / lit_frames_;
  found.mean_std_rad =
      ((mean * covariance_ * mean.transpose()).diagonal().array() + of_mean).sqrt();
  for (std::size_t f = 0; f < frames_.size(); ++f) {
    const Frame& frame = frames_[f];
    const bool lit = !frame.seen.empty();
    found.rotation_rad.push_back(lit ? frame.turn_rad : Eigen::Vector3d::Zero().eval());
    found.covariance.push_back(lit ? frame.information.inverse().eval()
                                   : Eigen::Matrix3d(turn_variance_.asDiagonal()));
    const Eigen::Matrix3Xd own = responses[f] - mean;
    if (lit) found.covariance.back() += own * covariance_ * own.transpose();
  }
  return found;
}

}  // namespace

std::optional<TurnSolution> solve_turns(const TurnProblem& problem) {
  Fit fit(problem);
  if (!fit.any()) return std::nullopt;
  fit.descend();
  return fit.solution();
}

}  // namespace vildar
