#include "track/drive_attitude.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "track/turn_solver.h"

namespace vildar {
namespace {

// Centres of lights are not trusted beyond this.
constexpr double kLeastSightingSigma_px = 0.05;
// More frames are solved in parts, each of which has a mean pose of its own; and of a street full
// of lit windows the longest seen tell enough, where the effort grows with the cube of their
// number.
constexpr std::size_t kMostFrames = 400, kMostLights = 32;

// Less movement than this is not told from what coding does to the centres of lights; and a camera
// that shakes swings, by 0.75 Hz or more, where a light that does not stand draws its turns aside
// once or twice.
bool shakes(const TurnSolution& turns, double focal_px, double seconds) {
  constexpr double kLeastMovement_px = 0.25, kFewestCrossings = 4.0, kLeastPerSecond = 1.5;
  const double fewest = std::max(kFewestCrossings, kLeastPerSecond * seconds);
  return ((turns.std_rad.array() > kLeastMovement_px / focal_px) && turns.crossings >= fewest)
      .head<2>()
      .any();
}

}  // namespace

DriveAttitude::DriveAttitude(const Site& site)
    : camera_(*site.camera),
      pose_std_rad_(site.camera->pitch_rad.std, site.camera->yaw_rad.std,
                    site.camera->roll_rad.std),
      focal_px_(camera_.focal_px()),
      ego_(*site.ego, site.road) {}

void DriveAttitude::begin(std::int64_t frame, double time_s) {
  const DrivenPose pose =
      moments_.empty() ? DrivenPose{.time_s = time_s} : ego_.driven(moments_.back().pose, time_s);
  moments_.push_back({frame, pose, {}});
}

std::size_t DriveAttitude::index_of(std::int64_t frame) const {
  return static_cast<std::size_t>(std::ranges::lower_bound(moments_, frame, {}, &Moment::frame) -
                                  moments_.begin());
}

void DriveAttitude::add(std::uint64_t light, const std::vector<StaticSighting>& sightings) {
  for (const StaticSighting& one : sightings) {
    const std::size_t index = index_of(one.frame);
    if (index < moments_.size() && moments_[index].frame == one.frame)
      moments_[index].seen.push_back({light, one});
  }
}

std::vector<CameraTurn> DriveAttitude::turns_between(std::size_t from, std::size_t to) const {
  std::map<std::uint64_t, std::size_t> looks;
  for (std::size_t i = from; i < to; ++i)
    for (const Seen& seen : moments_[i].seen) ++looks[seen.light];
  std::vector<std::pair<std::size_t, std::uint64_t>> longest;
  for (const auto& [light, count] : looks) longest.emplace_back(count, light);
  std::ranges::sort(longest, std::greater{});
  longest.resize(std::min(longest.size(), kMostLights));
  std::map<std::uint64_t, std::size_t> numbers;
  for (const auto& [count, light] : longest) numbers.emplace(light, numbers.size());

  TurnProblem problem;
  problem.camera_from_road = camera_.camera_from_road();
  problem.pose_std_rad = pose_std_rad_;
  problem.frames = to - from;
  problem.lights = numbers.size();
  for (std::size_t i = from; i < to; ++i)
    for (const auto& [light, sighting] : moments_[i].seen) {
      const auto number = numbers.find(light);
      if (number == numbers.end()) continue;
      const DrivenPose seen_from = ego_.driven(moments_[i].pose, sighting.time_s);
      problem.sightings.push_back(
          {i - from, number->second, sighting.time_s, Eigen::Vector2d(seen_from.x_m, seen_from.y_m),
           seen_from.heading_rad, sighting.at_px / focal_px_,
           std::max(sighting.sigma_px, kLeastSightingSigma_px) / focal_px_});
    }
  const auto found = solve_turns(problem);
  std::vector<CameraTurn> turns;
  const double seconds = moments_[to - 1].pose.time_s - moments_[from].pose.time_s;
  if (!found || !shakes(*found, focal_px_, seconds)) return turns;
  for (std::size_t i = 0; i < problem.frames; ++i)
    turns.push_back({found->rotation_rad[i], found->covariance[i], found->mean_std_rad});
  return turns;
}

std::vector<std::optional<CameraTurn>> DriveAttitude::turns_in(
    std::span<const std::int64_t> frames) const {
  std::vector<std::optional<CameraTurn>> turns(frames.size());
  if (frames.empty()) return turns;
  const std::size_t from = index_of(frames.front()), to = index_of(frames.back() + 1);
  const std::size_t parts = (to - from + kMostFrames - 1) / kMostFrames;
  std::vector<CameraTurn> solved;
  for (std::size_t part = 0; part < parts; ++part) {
    const std::vector<CameraTurn> found =
        turns_between(from + part * (to - from) / parts, from + (part + 1) * (to - from) / parts);
    // Frames as they were seen beside such that are corrected would be a step.
    if (found.empty()) return turns;
    solved.insert(solved.end(), found.begin(), found.end());
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::size_t index = index_of(frames[i]);
    if (index < to && moments_[index].frame == frames[i]) turns[i] = solved[index - from];
  }
  return turns;
}

void DriveAttitude::forget_before(std::int64_t frame) {
  // The way goes on from the last one.
  while (moments_.size() > 1 && moments_.front().frame < frame) moments_.pop_front();
}

}  // namespace vildar
