#include "track/attitude.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace vildar {
namespace {

// A shaken camera turns by less than this; one light leaves a turn about itself open up to here.
constexpr double kMostTurn_rad = 0.035;
// Centres of lights are not trusted beyond this before their own scatter is known.
constexpr double kLeastSigma_px = 0.05;
constexpr double kMostFramesInReference = 250.0;
constexpr double kEnoughFrames = 25.0;
// Less movement than this is not told from what coding does to the centres of lights; and a camera
// that shakes moves between frames, while coding leaves lights where they are until it draws the
// picture anew.
constexpr double kLeastMovement_px = 0.25, kStill_px = 0.03;

}  // namespace

void Attitude::Movement::add(double turn_rad, double noise_rad2, double still_rad) {
  moved += frames > 0.0 && std::abs(turn_rad - last_rad) > still_rad;
  last_rad = turn_rad;
  const bool now_above = turn_rad > mean_rad();
  crossings += frames > 0.0 && now_above != above;
  above = now_above;
  frames += 1.0;
  sum_rad += turn_rad;
  square_sum_rad2 += turn_rad * turn_rad;
  noise_sum_rad2 += noise_rad2;
}

double Attitude::Movement::variance_rad2() const {
  if (!(frames > 0.0)) return 0.0;
  return std::max(0.0, square_sum_rad2 / frames - mean_rad() * mean_rad() - noise_rad2());
}

bool Attitude::Movement::moves(double least_rad) const {
  constexpr double kShare = 0.5;
  return frames >= kEnoughFrames && moved > kShare * frames &&
         variance_rad2() > std::max(noise_rad2(), least_rad * least_rad);
}

void Attitude::add(std::uint64_t light, const std::vector<StaticSighting>& sightings) {
  if (sightings.empty()) return;
  const auto [entry, is_new] = lights_.try_emplace(light);
  Light& own = entry->second;
  if (is_new) {
    for (const StaticSighting& one : sightings) {
      const auto turn = turns_.find(one.frame);
      own.reference_px += turn == turns_.end() ? one.at_px
                                               : focal_px_ * rotated(one.at_px / focal_px_,
                                                                     turn->second.rotation_rad);
      own.error_px2 += one.sigma_px * one.sigma_px;
    }
    own.frames = static_cast<double>(sightings.size());
    own.reference_px /= own.frames;
    own.error_px2 = std::max(own.error_px2 / own.frames, kLeastSigma_px * kLeastSigma_px);
  }
  for (const StaticSighting& one : sightings) {
    seen_[one.frame].push_back({light, one.at_px, one.sigma_px});
    changed_.insert(one.frame);
  }
}

void Attitude::solve(std::int64_t frame) {
  for (const std::int64_t changed : changed_) {
    const std::vector<Seen>& seen = seen_.at(changed);
    const Turn turn = turn_of(seen);
    const bool is_new = turns_.insert_or_assign(changed, turn).second;
    if (changed == frame) follow(seen, turn);
    if (!is_new) continue;
    const Eigen::Vector3d noise_rad2 = turn.information.inverse().diagonal();
    constexpr double kTold = 0.03;  // of the most, as a sigma
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      if (noise_rad2[axis] < kTold * kTold * kMostTurn_rad * kMostTurn_rad)
        movement_[static_cast<std::size_t>(axis)].add(turn.rotation_rad[axis], noise_rad2[axis],
                                                      kStill_px / focal_px_);
  }
  changed_.clear();
}

// Weighted least squares, lights that do not move with the others tamed step by step.
Attitude::Turn Attitude::turn_of(const std::vector<Seen>& seen) const {
  constexpr int kSteps = 8;
  constexpr double kHuber = 2.0;
  Turn turn;
  for (int step = 0; step < kSteps; ++step) {
    Eigen::Matrix3d information = Eigen::Matrix3d::Identity() / (kMostTurn_rad * kMostTurn_rad);
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Seen& one : seen) {
      const Light& light = lights_.at(one.light);
      const Eigen::Vector2d expected = rotated(light.reference_px / focal_px_, -turn.rotation_rad);
      const Eigen::Matrix<double, 2, 3> effect = focal_px_ * turn_effect(expected);
      const Eigen::Vector2d left_px = one.at_px - focal_px_ * expected;
      const Eigen::Vector2d moved_px = left_px + effect * turn.rotation_rad;
      const double variance_px2 = std::max(one.sigma_px * one.sigma_px, light.error_px2);
      const double left = left_px.norm() / std::sqrt(2.0 * variance_px2);
      // The first step takes all lights alike: what they have in common may be many sigmas.
      const double trust = step == 0 || left < kHuber ? 1.0 : kHuber / left;
      information += trust / variance_px2 * effect.transpose() * effect;
      right += trust / variance_px2 * effect.transpose() * moved_px;
    }
    turn.information = information;
    turn.rotation_rad = information.ldlt().solve(right);
  }
  return turn;
}

// The references and the scatter of the lights follow what the turn leaves.
void Attitude::follow(const std::vector<Seen>& seen, const Turn& turn) {
  constexpr double kOutlier2 = 16.0, kTurns = 3.0;
  // Coordinates over those that the turn leaves free.
  const double coordinates = 2.0 * static_cast<double>(seen.size());
  const double taken = coordinates / std::max(1.0, coordinates - kTurns);
  for (const Seen& one : seen) {
    Light& light = lights_.at(one.light);
    const Eigen::Vector2d left_px =
        focal_px_ * rotated(one.at_px / focal_px_, turn.rotation_rad) - light.reference_px;
    light.frames = std::min(light.frames + 1.0, kMostFramesInReference);
    light.reference_px += left_px / light.frames;
    const double square_px2 =
        std::min(0.5 * taken * left_px.squaredNorm(), kOutlier2 * light.error_px2);
    light.error_px2 += (square_px2 - light.error_px2) / light.frames;
    light.error_px2 = std::max(light.error_px2, kLeastSigma_px * kLeastSigma_px);
  }
}

std::optional<CameraTurn> Attitude::at(std::int64_t frame) const {
  const auto found = turns_.find(frame);
  const Turn seen = found == turns_.end() ? Turn{} : found->second;
  // About the way ahead, a light off the axis moves by a part of what it does about the others.
  constexpr std::array<double, 3> kMovement{1.0, 1.0, 0.3};
  Eigen::Vector3d mean_rad, variance_rad2;
  double moving = 0.0, moving_variance_rad2 = 0.0;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Movement& movement = movement_[static_cast<std::size_t>(axis)];
    const double least_rad =
        kLeastMovement_px / focal_px_ / kMovement[static_cast<std::size_t>(axis)];
    mean_rad[axis] = movement.mean_rad();
    variance_rad2[axis] = movement.variance_rad2();
    if (!movement.moves(least_rad)) continue;
    moving += 1.0;
    moving_variance_rad2 += variance_rad2[axis];
  }
  // No more movement than the lights' own noise: correcting it would add more than it takes.
  if (moving == 0.0) return std::nullopt;
  CameraTurn turn;
  Eigen::Matrix3d precision = seen.information;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Movement& movement = movement_[static_cast<std::size_t>(axis)];
    // An axis of which the lights tell nothing may turn as the others do.
    if (movement.frames < kEnoughFrames) variance_rad2[axis] = moving_variance_rad2 / moving;
    constexpr double kLeast_rad2 = 1e-12;
    variance_rad2[axis] = std::max(variance_rad2[axis], kLeast_rad2);
    precision(axis, axis) += 1.0 / variance_rad2[axis];
    turn.mean_std_rad[axis] = std::sqrt(variance_rad2[axis] / std::max(1.0, movement.crossings));
  }
  turn.covariance = precision.inverse();
  turn.rotation_rad = turn.covariance * seen.information * (seen.rotation_rad - mean_rad);
  return turn;
}

void Attitude::forget_before(std::int64_t frame) {
  seen_.erase(seen_.begin(), seen_.lower_bound(frame));
  turns_.erase(turns_.begin(), turns_.lower_bound(frame));
}

}  // namespace vildar
