#include "evaluate/matching.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/assignment.h"

namespace vildar {
namespace {

constexpr double kSmallestScale_px = 10.0;
constexpr double kSameVehicle = 0.5;

double distance_px(const LampPixels& truth, const LampPixels& run) {
  const bool run_saw_one = !run.left_px || !run.right_px;
  if (!run_saw_one || !truth.left_px || !truth.right_px)
    return (truth.middle_px() - run.middle_px()).norm();
  return std::min((*truth.left_px - run.middle_px()).norm(),
                  (*truth.right_px - run.middle_px()).norm());
}

// Scores of pairs that may be matched; 0 for those that may not.
using Scores = Eigen::MatrixXd;

Scores image_scores(std::span<const TruthVehicle> truth, std::span<const RunVehicle> run) {
  Scores scores = Scores::Zero(std::ssize(truth), std::ssize(run));
  for (std::size_t i = 0; i < truth.size(); ++i) {
    std::map<std::int64_t, const LampPixels*> visible;
    for (const TruthSighting& sighting : truth[i].sightings)
      if (sighting.visible()) visible.emplace(sighting.frame, &sighting.lamps);
    for (std::size_t j = 0; j < run.size(); ++j) {
      std::size_t common = 0, seen = 0;
      double sum = 0.0;
      for (const RunSighting& sighting : run[j].sightings) {
        if (!sighting.lamps.any()) continue;
        ++seen;
        const auto found = visible.find(sighting.frame);
        if (found == visible.end()) continue;
        ++common;
        sum += lamp_similarity(*found->second, sighting.lamps);
      }
      const bool enough = common > 0 && 2 * common >= std::min(seen, visible.size());
      if (enough && sum >= kSameVehicle * static_cast<double>(common)) scores(i, j) = sum;
    }
  }
  return scores;
}

bool has_pixels(const RunVehicle& vehicle) {
  return std::ranges::any_of(vehicle.sightings, [](const RunSighting& s) { return s.lamps.any(); });
}

bool has_pixels(const TruthVehicle& vehicle) {
  return std::ranges::any_of(vehicle.sightings,
                             [](const TruthSighting& s) { return s.lamps.any(); });
}

struct Presence {
  double first_s = 0.0, last_s = 0.0;
};

// Truth may go on after a vehicle went past the sensors.
std::optional<Presence> presence_of(const TruthVehicle& truth) {
  std::optional<Presence> presence;
  for (const TruthSighting& sighting : truth.sightings) {
    if (!sighting.lamps.any() && sighting.range_m && *sighting.range_m <= 0.0) continue;
    if (!presence) presence = {sighting.t_s, sighting.t_s};
    presence->last_s = sighting.t_s;
  }
  return presence;
}

// A photodiode notices a vehicle around the moment at which it is nearest, long after it came into
// view and just before it goes past; one that drives away is nearest when it comes into view.
double passing_time_off_s(const TruthVehicle& truth, const Presence& presence,
                          const RunVehicle& run) {
  const double first_off_s = std::abs(presence.first_s - run.t_first_s);
  const double last_off_s = std::abs(presence.last_s - run.t_last_s);
  if (truth.direction == "oncoming") return last_off_s;
  if (truth.direction == "receding") return first_off_s;
  return std::min(first_off_s, last_off_s);
}

double time_score(const TruthVehicle& truth, const RunVehicle& run) {
  constexpr double kNearest_m = 5.0;  // below this the range says little about who it is
  constexpr double kPassing_s = 0.5;
  constexpr double kWrongWay = 0.5;
  const std::optional<Presence> presence = presence_of(truth);
  if (!presence) return 0.0;
  const double from_s = std::max(presence->first_s, run.t_first_s);
  const double to_s = std::min(presence->last_s, run.t_last_s);
  if (to_s < from_s) return 0.0;
  const double duration_s = run.t_last_s - run.t_first_s;
  const double share = duration_s > 0.0 ? (to_s - from_s) / duration_s : 1.0;
  if (share < 0.5) return 0.0;
  double score = share / (1.0 + passing_time_off_s(truth, *presence, run) / kPassing_s);
  if (!truth.direction.empty() && !run.direction.empty() && truth.direction != run.direction)
    score *= kWrongWay;
  if (!run.range_ref_m || !run.outcome.speed) return score;
  if (const auto true_m = truth.range_at(run.outcome.speed->t_ref_s))
    score /= 1.0 + std::abs(*true_m - *run.range_ref_m) / std::max(kNearest_m, std::abs(*true_m));
  return score;
}

Scores time_scores(std::span<const TruthVehicle> truth, std::span<const RunVehicle> run,
                   const Matching& so_far, bool all) {
  Scores scores = Scores::Zero(std::ssize(truth), std::ssize(run));
  for (std::size_t i = 0; i < truth.size(); ++i)
    for (std::size_t j = 0; j < run.size(); ++j)
      if (!so_far.run_of_truth[i] && (all || !has_pixels(run[j])))
        scores(i, j) = time_score(truth[i], run[j]);
  return scores;
}

std::vector<AssignedPair> best_pairs(const Eigen::MatrixXd& score) {
  std::vector<double> cost;
  for (Eigen::Index i = 0; i < score.rows(); ++i)
    for (Eigen::Index j = 0; j < score.cols(); ++j) cost.push_back(-score(i, j));
  std::vector<AssignedPair> pairs = assign(cost, score.rows(), score.cols());
  std::erase_if(pairs, [&](const AssignedPair& p) { return score(p.row, p.column) <= 0.0; });
  return pairs;
}

// Where the best track of a vehicle has no speed and another one that shows it has, the vehicle was
// measured: by that one, of several by the one that agrees best.
void prefer_measured(const Scores& scores, std::span<const RunVehicle> run, Matching& matching) {
  const auto has_speed = [&](std::size_t j) { return run[j].outcome.speed.has_value(); };
  for (std::size_t j = 0; j < run.size(); ++j) {
    if (!matching.duplicate_of[j] || !has_speed(j)) continue;
    const std::size_t i = *matching.duplicate_of[j];
    const std::size_t now = *matching.run_of_truth[i];
    if (has_speed(now)) continue;
    std::size_t best = j;
    for (std::size_t k = j + 1; k < run.size(); ++k)
      if (matching.duplicate_of[k] == i && has_speed(k) && scores(i, k) > scores(i, best)) best = k;
    matching.run_of_truth[i] = best;
    matching.duplicate_of[best].reset();
    matching.duplicate_of[now] = i;
  }
}

void take(const Scores& scores, std::span<const RunVehicle> run, Matching& matching) {
  std::vector<bool> taken(matching.duplicate_of.size());
  for (const AssignedPair& pair : best_pairs(scores)) {
    matching.run_of_truth[pair.row] = pair.column;
    taken[pair.column] = true;
  }
  for (std::size_t j = 0; j < taken.size(); ++j) {
    if (taken[j] || scores.rows() == 0) continue;
    Eigen::Index nearest = 0;
    if (scores.col(j).maxCoeff(&nearest) > 0.0) matching.duplicate_of[j] = nearest;
  }
  prefer_measured(scores, run, matching);
}

struct SeenInFrame {
  std::vector<std::pair<int, const TruthSighting*>> truth;
  std::vector<std::pair<int, const RunSighting*>> run;
};

TrackingFrame scored(const SeenInFrame& seen) {
  Eigen::MatrixXd similarity(std::ssize(seen.truth), std::ssize(seen.run));
  for (Eigen::Index i = 0; i < similarity.rows(); ++i)
    for (Eigen::Index j = 0; j < similarity.cols(); ++j)
      similarity(i, j) = lamp_similarity(seen.truth[i].second->lamps, seen.run[j].second->lamps);
  const Eigen::MatrixXd same =
      (similarity.array() < kSameVehicle)
          .select(Eigen::MatrixXd::Zero(similarity.rows(), similarity.cols()), similarity);
  std::vector<bool> ignored(seen.run.size());
  for (const AssignedPair& pair : best_pairs(same))
    if (seen.truth[pair.row].second->occluded) ignored[pair.column] = true;
  TrackingFrame frame;
  std::vector<Eigen::Index> rows, columns;
  for (std::size_t i = 0; i < seen.truth.size(); ++i) {
    if (seen.truth[i].second->occluded) continue;
    rows.push_back(i);
    frame.truth_ids.push_back(seen.truth[i].first);
  }
  for (std::size_t j = 0; j < seen.run.size(); ++j) {
    if (ignored[j]) continue;
    columns.push_back(j);
    frame.run_ids.push_back(seen.run[j].first);
  }
  frame.similarity = similarity(rows, columns);
  return frame;
}

}  // namespace

double lamp_similarity(const LampPixels& truth, const LampPixels& run) {
  if (!truth.any() || !run.any()) return 0.0;
  double scale_px = kSmallestScale_px;
  if (truth.left_px && truth.right_px)
    scale_px = std::max(scale_px, (*truth.right_px - *truth.left_px).norm());
  return 1.0 - std::min(1.0, distance_px(truth, run) / scale_px);
}

Matching match(std::span<const TruthVehicle> truth, std::span<const RunVehicle> run) {
  Matching matching;
  matching.run_of_truth.resize(truth.size());
  matching.duplicate_of.resize(run.size());
  matching.by_image =
      std::ranges::any_of(truth, [](const TruthVehicle& v) { return has_pixels(v); }) &&
      std::ranges::any_of(run, [](const RunVehicle& v) { return has_pixels(v); });
  if (matching.by_image) take(image_scores(truth, run), run, matching);
  take(time_scores(truth, run, matching, !matching.by_image), run, matching);
  return matching;
}

std::vector<TrackingFrame> tracking_frames(std::span<const TruthVehicle> truth,
                                           std::span<const RunVehicle> run) {
  std::map<std::int64_t, SeenInFrame> frames;
  for (std::size_t i = 0; i < truth.size(); ++i)
    for (const TruthSighting& sighting : truth[i].sightings)
      if (sighting.lamps.any())
        frames[sighting.frame].truth.emplace_back(static_cast<int>(i), &sighting);
  for (std::size_t j = 0; j < run.size(); ++j)
    for (const RunSighting& sighting : run[j].sightings)
      if (sighting.lamps.any())
        frames[sighting.frame].run.emplace_back(static_cast<int>(j), &sighting);
  std::vector<TrackingFrame> result;
  for (const auto& [number, seen] : frames) result.push_back(scored(seen));
  return result;
}

}  // namespace vildar
