#include "track/drive_attitude.h"

#include <algorithm>
#include <cmath>

#include "track/turn_solver.h"

namespace vildar {
namespace {

// Centres of lights are not trusted beyond this.
constexpr double kLeastSigma_px = 0.05;
// More frames are solved in parts: the mean pose of each is its own.
constexpr std::size_t kMostFrames = 400;

// Less movement than this is not told from what coding does to the centres of lights; and a camera
// that shakes swings, where a light that does not stand draws its turns aside once.
bool shakes(const TurnSolution& turns, double focal_px) {
  constexpr double kLeastMovement_px = 0.25, kFewestCrossings = 4.0;
  return ((turns.std_rad.array() > kLeastMovement_px / focal_px) &&
          turns.crossings >= kFewestCrossings)
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

DriveAttitude::Moment DriveAttitude::moved(const Moment& from, double to_s) const {
  constexpr double kLongestStep_s = 0.02;
  Moment to{0, to_s, from.way_m, from.place_m, from.heading_rad, {}};
  const double span_s = to_s - from.time_s;
  const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(span_s) / kLongestStep_s)));
  for (int i = 0; i < steps; ++i) {
    const double middle_s = from.time_s + (i + 0.5) * span_s / steps;
    const double length_m = ego_.speed_mps(middle_s) * span_s / steps;
    const double turn_rad = ego_.turn_rate_rad_per_s(middle_s, to.way_m) * span_s / steps;
    const double along_rad = to.heading_rad + 0.5 * turn_rad;
    to.place_m += length_m * Eigen::Vector2d(std::cos(along_rad), std::sin(along_rad));
    to.heading_rad += turn_rad;
    to.way_m += length_m;
  }
  return to;
}

void DriveAttitude::begin(std::int64_t frame, double time_s) {
  Moment moment = moments_.empty() ? Moment{} : moved(moments_.back(), time_s);
  moment.frame = frame;
  moment.time_s = time_s;
  moments_.push_back(std::move(moment));
  solved_.clear();
}

std::size_t DriveAttitude::index_of(std::int64_t frame) const {
  const auto found = std::ranges::lower_bound(moments_, frame, {}, &Moment::frame);
  if (found == moments_.end() || found->frame != frame) return moments_.size();
  return static_cast<std::size_t>(found - moments_.begin());
}

void DriveAttitude::add(std::uint64_t light, const std::vector<StaticSighting>& sightings) {
  for (const StaticSighting& one : sightings) {
    const std::size_t index = index_of(one.frame);
    if (index < moments_.size()) moments_[index].seen.push_back({light, one});
  }
  solved_.clear();
}

std::vector<CameraTurn> DriveAttitude::turns_between(std::size_t from, std::size_t to) const {
  TurnProblem problem;
  problem.camera_from_road = camera_.camera_from_road();
  problem.pose_std_rad = pose_std_rad_;
  problem.frames = to - from;
  std::map<std::uint64_t, std::size_t> numbers;
  for (std::size_t i = from; i < to; ++i)
    for (const auto& [light, sighting] : moments_[i].seen) {
      const std::size_t number = numbers.try_emplace(light, numbers.size()).first->second;
      const Moment seen_from = moved(moments_[i], sighting.time_s);
      problem.sightings.push_back({i - from, number, sighting.time_s, seen_from.place_m,
                                   seen_from.heading_rad, sighting.at_px / focal_px_,
                                   std::max(sighting.sigma_px, kLeastSigma_px) / focal_px_});
    }
  problem.lights = numbers.size();
  const auto found = solve_turns(problem);
  std::vector<CameraTurn> turns;
  if (!found || !shakes(*found, focal_px_)) return turns;
  for (std::size_t i = 0; i < problem.frames; ++i)
    turns.push_back({found->rotation_rad[i], found->covariance[i], found->mean_std_rad});
  return turns;
}

std::optional<CameraTurn> DriveAttitude::at(std::int64_t frame) const {
  const std::size_t index = index_of(frame), size = moments_.size();
  if (index == size) return std::nullopt;
  const std::size_t blocks = (size + kMostFrames - 1) / kMostFrames;
  const std::size_t length = (size + blocks - 1) / blocks;
  const std::size_t from = index / length * length;
  const auto [entry, is_new] = solved_.try_emplace(from);
  if (is_new) entry->second = turns_between(from, std::min(from + length, size));
  return entry->second.empty() ? std::nullopt : std::optional(entry->second[index - from]);
}

void DriveAttitude::forget_before(std::int64_t frame) {
  // The way goes on from the last one.
  while (moments_.size() > 1 && moments_.front().frame < frame) {
    moments_.pop_front();
    solved_.clear();
  }
}

}  // namespace vildar
