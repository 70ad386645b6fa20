#include "estimate/frame_steps.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "core/camera_rate.h"
#include "core/median.h"
#include "core/robust_line.h"

namespace vildar {
namespace {

constexpr std::size_t kMostSteps = 20000;

/// The way of a lamp from one frame to the next.
struct Step {
  std::int64_t frame = 0;
  double duration_s = 0.0;
  Eigen::Vector2d way_px = Eigen::Vector2d::Zero();
  double sigma_px = 0.0;
};

std::vector<Step> steps_of(const VehicleTrack& track,
                           std::optional<LampSighting> VehicleSighting::*side) {
  std::vector<Step> steps;
  for (std::size_t i = 0; i + 1 < track.sightings.size(); ++i) {
    const VehicleSighting &from = track.sightings[i], &to = track.sightings[i + 1];
    const auto &a = from.*side, &b = to.*side;
    if (!a || !b || to.frame != from.frame + 1) continue;
    const double duration_s = seconds_of(to.time) - seconds_of(from.time);
    if (!(duration_s > 0.0)) continue;
    steps.push_back({from.frame, duration_s, b->centre_px - a->centre_px,
                     std::hypot(a->centre_sigma_px.maxCoeff(), b->centre_sigma_px.maxCoeff())});
  }
  return steps;
}

/// Image velocity at one step, told by those around it, and how far these lie off it.
struct LocalVelocity {
  Eigen::Vector2d px_per_s;
  double scatter_px;
};

// A velocity that changes evenly, which jumps among the neighbours do not move.
std::optional<LocalVelocity> velocity_at(const std::vector<Step>& steps, std::size_t at) {
  constexpr std::int64_t kReach = 7;  // frames
  constexpr std::size_t kFewest = 10;
  std::size_t first = at, end = at + 1;
  while (first > 0 && steps[at].frame - steps[first - 1].frame <= kReach) --first;
  while (end < steps.size() && steps[end].frame - steps[at].frame <= kReach) ++end;
  if (end - first < kFewest) return std::nullopt;
  const std::span<const Step> around = std::span(steps).subspan(first, end - first);

  std::vector<double> frames, u_px_per_s, v_px_per_s, off_px;
  for (const Step& step : around) {
    frames.push_back(static_cast<double>(step.frame - steps[at].frame));
    u_px_per_s.push_back(step.way_px.x() / step.duration_s);
    v_px_per_s.push_back(step.way_px.y() / step.duration_s);
  }
  const RobustLine u = least_deviations_line(frames, u_px_per_s);
  const RobustLine v = least_deviations_line(frames, v_px_per_s);
  for (std::size_t i = 0; i < around.size(); ++i)
    off_px.push_back((around[i].way_px -
                      around[i].duration_s * Eigen::Vector2d(u.at(frames[i]), v.at(frames[i])))
                         .norm());
  // Of the lengths of two-dimensional errors half are shorter than 1.177 sigma.
  return LocalVelocity{{u.at_zero, v.at_zero}, median(off_px) / 1.177};
}

}  // namespace

std::int64_t FrameSteps::Tally::unfilled() const {
  // Noise, and lamps taken for others, make few steps of just two frames' ways.
  return jumps > 2 * odd && !regular() ? std::max<std::int64_t>(0, missing - repeated) : 0;
}

// Nearly all jumps at one remainder, or at two neighbouring ones where the period slips, and a jump
// in most of the steps there.
bool FrameSteps::Tally::regular() const {
  constexpr double kOff = 0.04;  // by how much few jumps mistake the rate
  const double taken_hz =
      (1.0 + static_cast<double>(jumps) / static_cast<double>(judged)) / frame_s;
  if (!is_camera_rate(taken_hz, kOff)) return false;
  constexpr double kNearlyAll = 0.8, kMost = 0.5;
  for (std::size_t period = 2; period < jumps_at.size(); ++period)
    for (std::size_t at = 0; at < period; ++at) {
      const std::size_t next = (at + 1) % period;
      const auto both = static_cast<double>(jumps_at[period][at] + jumps_at[period][next]);
      const auto judged_there =
          0.5 * static_cast<double>(judged_at[period][at] + judged_at[period][next]);
      if (both >= kNearlyAll * static_cast<double>(jumps) && both >= kMost * judged_there)
        return true;
    }
  return false;
}

bool FrameSteps::Evidence::is_judged() const {
  constexpr double kSharp = 0.15;  // frames' ways
  return weight * kSharp * kSharp > 1.0;
}

std::optional<double> FrameSteps::Evidence::whole_surplus() const {
  constexpr double kPlain = 0.35, kWhole = 0.25;  // frames' ways
  const double surplus = along / weight, whole = std::round(surplus);
  if (std::abs(surplus) < kPlain) return 0.0;
  if (std::abs(surplus - whole) > kWhole || whole < -1.0) return std::nullopt;
  return whole;
}

void FrameSteps::Evidence::count_in(Tally& tally, std::int64_t frame) const {
  if (!is_judged()) return;
  const auto whole = whole_surplus();
  ++tally.judged;
  const bool jump = whole && *whole > 0.0;
  for (std::size_t period = 2; period < tally.judged_at.size(); ++period) {
    const auto at = static_cast<std::size_t>(frame) % period;
    ++tally.judged_at[period][at];
    tally.jumps_at[period][at] += jump;
  }
  if (!whole) {
    ++tally.odd;
  } else if (jump) {
    ++tally.jumps;
    tally.missing += static_cast<std::int64_t>(*whole);
  } else if (*whole < 0.0) {
    ++tally.repeated;
  }
}

void FrameSteps::add(const VehicleTrack& track) {
  for (const auto side : {&VehicleSighting::left, &VehicleSighting::right}) {
    const std::vector<Step> steps = steps_of(track, side);
    if (frame_s_ == 0.0 && !steps.empty()) frame_s_ = steps.front().duration_s;
    for (std::size_t i = 0; i < steps.size(); ++i) {
      if (steps[i].frame < first_kept_) continue;
      const auto velocity = velocity_at(steps, i);
      if (!velocity) continue;
      const Eigen::Vector2d way_px = steps[i].duration_s * velocity->px_per_s;
      const double sigma_px = std::max(steps[i].sigma_px, velocity->scatter_px);
      const double weight = 1.0 / (sigma_px * sigma_px);
      Evidence& evidence = steps_[steps[i].frame];
      evidence.along += weight * way_px.dot(steps[i].way_px - way_px);
      evidence.weight += weight * way_px.squaredNorm();
    }
  }
  for (; steps_.size() > kMostSteps; steps_.erase(steps_.begin())) {
    steps_.begin()->second.count_in(forgotten_, steps_.begin()->first);
    first_kept_ = steps_.begin()->first + 1;
  }
}

FrameSteps::Tally FrameSteps::between(std::int64_t first, std::int64_t last) const {
  Tally tally;
  tally.frame_s = frame_s_;
  for (auto at = steps_.lower_bound(first); at != steps_.end() && at->first < last; ++at)
    at->second.count_in(tally, at->first);
  return tally;
}

FrameSteps::Tally FrameSteps::all() const {
  Tally tally = forgotten_;
  tally.frame_s = frame_s_;
  for (const auto& [frame, evidence] : steps_) evidence.count_in(tally, frame);
  return tally;
}

std::vector<std::int64_t> FrameSteps::after_one_missing() const {
  std::vector<std::int64_t> frames;
  for (const auto& [frame, evidence] : steps_)
    if (evidence.is_judged() && evidence.whole_surplus() == 1.0) frames.push_back(frame + 1);
  return frames;
}

double FrameSteps::missing_share(std::int64_t first, std::int64_t last) const {
  constexpr std::int64_t kFewestJudged = 20;
  const Tally own = between(first, last);
  if (own.judged >= kFewestJudged && own.unfilled() == 0) return 0.0;
  const Tally clip = all();
  if (clip.unfilled() < kFewestMissing) return 0.0;
  const Tally& tally = own.judged < kFewestJudged ? clip : own;
  return static_cast<double>(tally.unfilled()) / static_cast<double>(tally.judged);
}

bool bears_on(double missing_share, const VehicleResult& result) {
  constexpr double kMostOfSigma = 0.5;
  if (result.withheld || !result.used_camera) return false;
  const double closing_mps = std::abs(result.closing_speed_mps.value_or(result.speed.speed_mps));
  return missing_share * closing_mps > kMostOfSigma * result.speed.std_mps;
}

}  // namespace vildar
