#include "evaluate/tracking_metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <unordered_map>

#include "core/assignment.h"

namespace vildar {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kSameObject = 0.5;  // similarity at which CLEAR and the identity scores match

double threshold(std::size_t index) { return 0.05 + static_cast<double>(index) * 0.05; }

double ratio(double part, double whole) { return part / std::max(1.0, whole); }

// The frames with ids counted from 0, as the matrices below are indexed.
struct Sequence {
  struct Frame {
    std::vector<Eigen::Index> truth, run;
    const Eigen::MatrixXd* similarity = nullptr;
  };
  std::vector<Frame> frames;
  std::vector<double> truth_detections, run_detections;  // per id
};

class Numbering {
 public:
  Eigen::Index operator()(int id, std::vector<double>& detections) {
    const auto [found, is_new] = number_.try_emplace(id, std::ssize(detections));
    if (is_new) detections.push_back(0.0);
    detections[found->second] += 1.0;
    return found->second;
  }

 private:
  std::unordered_map<int, Eigen::Index> number_;
};

Sequence numbered(std::span<const TrackingFrame> frames) {
  Sequence sequence;
  Numbering truth_number, run_number;
  for (const TrackingFrame& frame : frames) {
    const bool has_pairs = !frame.truth_ids.empty() && !frame.run_ids.empty();
    if (has_pairs && (frame.similarity.rows() != std::ssize(frame.truth_ids) ||
                      frame.similarity.cols() != std::ssize(frame.run_ids)))
      throw std::invalid_argument("tracking_scores: the similarity matrix of a frame is " +
                                  std::to_string(frame.similarity.rows()) + " x " +
                                  std::to_string(frame.similarity.cols()) + ", its ids are " +
                                  std::to_string(frame.truth_ids.size()) + " and " +
                                  std::to_string(frame.run_ids.size()));
    Sequence::Frame& to = sequence.frames.emplace_back();
    for (const int id : frame.truth_ids)
      to.truth.push_back(truth_number(id, sequence.truth_detections));
    for (const int id : frame.run_ids) to.run.push_back(run_number(id, sequence.run_detections));
    to.similarity = &frame.similarity;
  }
  return sequence;
}

Eigen::MatrixXd zero_pairs(const Sequence& sequence) {
  return Eigen::MatrixXd::Zero(std::ssize(sequence.truth_detections),
                               std::ssize(sequence.run_detections));
}

std::vector<AssignedPair> best_pairs(const Eigen::MatrixXd& score) {
  std::vector<double> cost;
  cost.reserve(score.size());
  for (Eigen::Index i = 0; i < score.rows(); ++i)
    for (Eigen::Index j = 0; j < score.cols(); ++j) cost.push_back(-score(i, j));
  return assign(cost, score.rows(), score.cols());
}

// How far two identities coincide over the whole sequence, before any choice between them: Luiten
// et al. 2021, section 4.4.
Eigen::MatrixXd global_alignment(const Sequence& sequence) {
  Eigen::MatrixXd potential = zero_pairs(sequence);
  for (const Sequence::Frame& frame : sequence.frames) {
    if (frame.truth.empty() || frame.run.empty()) continue;
    const Eigen::MatrixXd& similarity = *frame.similarity;
    const Eigen::RowVectorXd of_run = similarity.colwise().sum();
    const Eigen::VectorXd of_truth = similarity.rowwise().sum();
    for (Eigen::Index i = 0; i < similarity.rows(); ++i)
      for (Eigen::Index j = 0; j < similarity.cols(); ++j) {
        const double whole = of_run(j) + of_truth(i) - similarity(i, j);
        if (whole > kEpsilon) potential(frame.truth[i], frame.run[j]) += similarity(i, j) / whole;
      }
  }
  for (Eigen::Index i = 0; i < potential.rows(); ++i)
    for (Eigen::Index j = 0; j < potential.cols(); ++j)
      potential(i, j) /=
          sequence.truth_detections[i] + sequence.run_detections[j] - potential(i, j);
  return potential;
}

struct HotaMatch {
  Eigen::Index truth, run;
  double similarity;
};

// One assignment per frame serves all thresholds; a threshold then drops the pairs below it.
std::vector<HotaMatch> hota_matches(const Sequence& sequence) {
  const Eigen::MatrixXd alignment = global_alignment(sequence);
  std::vector<HotaMatch> matches;
  for (const Sequence::Frame& frame : sequence.frames) {
    if (frame.truth.empty() || frame.run.empty()) continue;
    Eigen::MatrixXd score = *frame.similarity;
    for (Eigen::Index i = 0; i < score.rows(); ++i)
      for (Eigen::Index j = 0; j < score.cols(); ++j)
        score(i, j) *= alignment(frame.truth[i], frame.run[j]);
    for (const AssignedPair& pair : best_pairs(score))
      matches.push_back({frame.truth[pair.row], frame.run[pair.column],
                         (*frame.similarity)(pair.row, pair.column)});
  }
  return matches;
}

double sum_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

HotaScores hota_of(const Sequence& sequence) {
  HotaScores scores;
  const double truth_total = sum_of(sequence.truth_detections);
  const double run_total = sum_of(sequence.run_detections);
  const std::vector<HotaMatch> matches = hota_matches(sequence);
  for (std::size_t a = 0; a < HotaScores::kThresholds; ++a) {
    Eigen::MatrixXd count = zero_pairs(sequence);
    double similarity_sum = 0.0, matched = 0.0;
    for (const HotaMatch& match : matches) {
      if (match.similarity < threshold(a) - kEpsilon) continue;
      count(match.truth, match.run) += 1.0;
      similarity_sum += match.similarity;
      matched += 1.0;
    }
    double accuracy = 0.0, recall = 0.0, precision = 0.0;
    for (Eigen::Index i = 0; i < count.rows(); ++i)
      for (Eigen::Index j = 0; j < count.cols(); ++j) {
        const double both = count(i, j);
        const double of_truth = sequence.truth_detections[i];
        const double of_run = sequence.run_detections[j];
        accuracy += both * ratio(both, of_truth + of_run - both);
        recall += both * ratio(both, of_truth);
        precision += both * ratio(both, of_run);
      }
    scores.true_positives[a] = matched;
    scores.false_negatives[a] = truth_total - matched;
    scores.false_positives[a] = run_total - matched;
    scores.association_accuracy[a] = ratio(accuracy, matched);
    scores.association_recall[a] = ratio(recall, matched);
    scores.association_precision[a] = ratio(precision, matched);
    scores.localisation[a] = matched > 0.0 ? similarity_sum / matched : 1.0;
  }
  return scores;
}

// Of CLEAR's memory there are two: the last run id a truth id ever had decides what is a switch;
// the one of the frame before decides which pair is kept together.
ClearScores clear_of(const Sequence& sequence) {
  ClearScores scores;
  scores.frames = std::ssize(sequence.frames);
  const std::size_t truths = sequence.truth_detections.size();
  std::vector<std::optional<Eigen::Index>> ever(truths), before(truths);
  std::vector<double> matched_frames(truths, 0.0);
  std::vector<std::int64_t> pieces(truths, 0);
  for (const Sequence::Frame& frame : sequence.frames) {
    const std::int64_t truth_count = std::ssize(frame.truth), run_count = std::ssize(frame.run);
    std::vector<AssignedPair> pairs;
    if (truth_count > 0 && run_count > 0) {
      Eigen::MatrixXd score = *frame.similarity;
      for (Eigen::Index i = 0; i < truth_count; ++i)
        for (Eigen::Index j = 0; j < run_count; ++j) {
          const auto truth = static_cast<std::size_t>(frame.truth[i]);
          if (score(i, j) < kSameObject - kEpsilon)
            score(i, j) = 0.0;
          else if (before[truth] == frame.run[j])
            score(i, j) += 1000.0;
        }
      for (const AssignedPair& pair : best_pairs(score))
        if (score(pair.row, pair.column) > kEpsilon) pairs.push_back(pair);
      std::vector<std::optional<Eigen::Index>> now(truths);
      for (const AssignedPair& pair : pairs) {
        const auto truth = static_cast<std::size_t>(frame.truth[pair.row]);
        const Eigen::Index run = frame.run[pair.column];
        if (ever[truth] && *ever[truth] != run) ++scores.id_switches;
        if (!before[truth]) ++pieces[truth];
        ever[truth] = now[truth] = run;
        matched_frames[truth] += 1.0;
        scores.similarity_sum += (*frame.similarity)(pair.row, pair.column);
      }
      before = std::move(now);
    }
    scores.true_positives += std::ssize(pairs);
    scores.false_negatives += truth_count - std::ssize(pairs);
    scores.false_positives += run_count - std::ssize(pairs);
  }
  for (std::size_t truth = 0; truth < truths; ++truth) {
    const double tracked = matched_frames[truth] / sequence.truth_detections[truth];
    ++(tracked > 0.8    ? scores.mostly_tracked
       : tracked >= 0.2 ? scores.partly_tracked
                        : scores.mostly_lost);
    scores.fragmentations += std::max<std::int64_t>(0, pieces[truth] - 1);
  }
  return scores;
}

// The pairing of identities with the most frames in common is the one with the fewest false
// positives and negatives, because their sum is all detections less twice the frames in common.
IdentityScores identity_of(const Sequence& sequence) {
  Eigen::MatrixXd common = zero_pairs(sequence);
  for (const Sequence::Frame& frame : sequence.frames)
    for (std::size_t i = 0; i < frame.truth.size(); ++i)
      for (std::size_t j = 0; j < frame.run.size(); ++j)
        if ((*frame.similarity)(i, j) >= kSameObject) common(frame.truth[i], frame.run[j]) += 1.0;
  double in_common = 0.0;
  for (const AssignedPair& pair : best_pairs(common)) in_common += common(pair.row, pair.column);
  IdentityScores scores;
  scores.true_positives = std::llround(in_common);
  scores.false_negatives = std::llround(sum_of(sequence.truth_detections) - in_common);
  scores.false_positives = std::llround(sum_of(sequence.run_detections) - in_common);
  return scores;
}

HotaScores::Curve ratios(const HotaScores::Curve& part, const HotaScores::Curve* other,
                         const HotaScores::Curve* another) {
  HotaScores::Curve result;
  for (std::size_t a = 0; a < result.size(); ++a)
    result[a] =
        ratio(part[a], part[a] + (other ? (*other)[a] : 0.0) + (another ? (*another)[a] : 0.0));
  return result;
}

}  // namespace

HotaScores::Curve HotaScores::detection_accuracy() const {
  return ratios(true_positives, &false_negatives, &false_positives);
}
HotaScores::Curve HotaScores::detection_recall() const {
  return ratios(true_positives, &false_negatives, nullptr);
}
HotaScores::Curve HotaScores::detection_precision() const {
  return ratios(true_positives, nullptr, &false_positives);
}
HotaScores::Curve HotaScores::hota() const {
  Curve result = detection_accuracy();
  for (std::size_t a = 0; a < result.size(); ++a)
    result[a] = std::sqrt(result[a] * association_accuracy[a]);
  return result;
}

double ClearScores::mota() const {
  return ratio(static_cast<double>(true_positives - false_positives - id_switches),
               static_cast<double>(true_positives + false_negatives));
}
double ClearScores::motp() const {
  return ratio(similarity_sum, static_cast<double>(true_positives));
}

double IdentityScores::idf1() const {
  const auto matched = static_cast<double>(true_positives);
  return ratio(matched, matched + 0.5 * static_cast<double>(false_positives + false_negatives));
}
double IdentityScores::recall() const {
  return ratio(static_cast<double>(true_positives),
               static_cast<double>(true_positives + false_negatives));
}
double IdentityScores::precision() const {
  return ratio(static_cast<double>(true_positives),
               static_cast<double>(true_positives + false_positives));
}

double mean_of(const HotaScores::Curve& curve) {
  return std::accumulate(curve.begin(), curve.end(), 0.0) / static_cast<double>(curve.size());
}

TrackingScores tracking_scores(std::span<const TrackingFrame> frames) {
  const Sequence sequence = numbered(frames);
  return {hota_of(sequence), clear_of(sequence), identity_of(sequence)};
}

TrackingScores combined(std::span<const TrackingScores> sequences) {
  TrackingScores all;
  for (const TrackingScores& one : sequences) {
    for (std::size_t a = 0; a < HotaScores::kThresholds; ++a) {
      const double weight = one.hota.true_positives[a];
      all.hota.true_positives[a] += weight;
      all.hota.false_negatives[a] += one.hota.false_negatives[a];
      all.hota.false_positives[a] += one.hota.false_positives[a];
      all.hota.association_accuracy[a] += weight * one.hota.association_accuracy[a];
      all.hota.association_recall[a] += weight * one.hota.association_recall[a];
      all.hota.association_precision[a] += weight * one.hota.association_precision[a];
      all.hota.localisation[a] += weight * one.hota.localisation[a];
    }
    all.clear.true_positives += one.clear.true_positives;
    all.clear.false_negatives += one.clear.false_negatives;
    all.clear.false_positives += one.clear.false_positives;
    all.clear.id_switches += one.clear.id_switches;
    all.clear.fragmentations += one.clear.fragmentations;
    all.clear.frames += one.clear.frames;
    all.clear.mostly_tracked += one.clear.mostly_tracked;
    all.clear.partly_tracked += one.clear.partly_tracked;
    all.clear.mostly_lost += one.clear.mostly_lost;
    all.clear.similarity_sum += one.clear.similarity_sum;
    all.identity.true_positives += one.identity.true_positives;
    all.identity.false_negatives += one.identity.false_negatives;
    all.identity.false_positives += one.identity.false_positives;
  }
  for (std::size_t a = 0; a < HotaScores::kThresholds; ++a) {
    const double weight = all.hota.true_positives[a];
    all.hota.association_accuracy[a] = ratio(all.hota.association_accuracy[a], weight);
    all.hota.association_recall[a] = ratio(all.hota.association_recall[a], weight);
    all.hota.association_precision[a] = ratio(all.hota.association_precision[a], weight);
    all.hota.localisation[a] = weight > 0.0 ? all.hota.localisation[a] / weight : 1.0;
  }
  return all;
}

}  // namespace vildar
