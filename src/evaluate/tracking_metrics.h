#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace vildar {

/// What truth and a tracker say of one frame. Ids are unique within a frame; a frame in which
/// neither has anything still counts as a frame.
struct TrackingFrame {
  std::vector<int> truth_ids;
  std::vector<int> run_ids;
  /// truth_ids.size() x run_ids.size(); 1 where they coincide, 0 where they have nothing in common.
  Eigen::MatrixXd similarity;
};

/// HOTA (Luiten et al. 2021) at the localisation thresholds 0.05, 0.10 ... 0.95.
struct HotaScores {
  static constexpr std::size_t kThresholds = 19;
  using Curve = std::array<double, kThresholds>;
  Curve true_positives{}, false_negatives{}, false_positives{};
  Curve association_accuracy{}, association_recall{}, association_precision{};
  Curve localisation{};

  Curve detection_accuracy() const;
  Curve detection_recall() const;
  Curve detection_precision() const;
  Curve hota() const;
};

/// CLEAR MOT (Bernardin and Stiefelhagen 2008) at similarity 0.5.
struct ClearScores {
  std::int64_t true_positives = 0, false_negatives = 0, false_positives = 0;
  std::int64_t id_switches = 0, fragmentations = 0, frames = 0;
  std::int64_t mostly_tracked = 0, partly_tracked = 0, mostly_lost = 0;
  double similarity_sum = 0.0;  ///< over the true positives

  double mota() const;
  double motp() const;
};

/// Identity scores (Ristani et al. 2016) at similarity 0.5.
struct IdentityScores {
  std::int64_t true_positives = 0, false_negatives = 0, false_positives = 0;

  double idf1() const;
  double recall() const;
  double precision() const;
};

struct TrackingScores {
  HotaScores hota;
  ClearScores clear;
  IdentityScores identity;
};

/// The mean over the thresholds, as HOTA, DetA, AssA and LocA are quoted.
double mean_of(const HotaScores::Curve& curve);

/// The scores of one sequence, number for number those of TrackEval (12c8791).
/// Throws std::invalid_argument where a similarity matrix does not fit its ids.
TrackingScores tracking_scores(std::span<const TrackingFrame> frames);

/// The scores of several sequences taken together, as TrackEval combines them.
TrackingScores combined(std::span<const TrackingScores> sequences);

}  // namespace vildar
