#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "core/assignment.h"
#include "evaluate/tracking_metrics.h"

namespace vildar {

// MOTChallenge text files as TrackEval's MotChallenge2DBox reads them for the class pedestrian.

struct MotBox {
  int id = 0;
  double left_px = 0.0, top_px = 0.0, width_px = 0.0, height_px = 0.0;
  double confidence = 1.0;
  int kind = 1;
};

using MotBoxes = std::map<int, std::vector<MotBox>>;  // by frame, from 1

inline MotBoxes read_mot(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw std::runtime_error("cannot read " + file.string());
  MotBoxes boxes;
  for (std::string line; std::getline(stream, line);) {
    std::ranges::replace(line, ',', ' ');
    std::istringstream cells(line);
    int frame = 0;
    MotBox box;
    if (cells >> frame >> box.id >> box.left_px >> box.top_px >> box.width_px >> box.height_px >>
        box.confidence >> box.kind)
      boxes[frame].push_back(box);
  }
  return boxes;
}

inline double intersection_over_union(const MotBox& a, const MotBox& b) {
  const double width =
      std::min(a.left_px + a.width_px, b.left_px + b.width_px) - std::max(a.left_px, b.left_px);
  const double height =
      std::min(a.top_px + a.height_px, b.top_px + b.height_px) - std::max(a.top_px, b.top_px);
  const double both = std::max(0.0, width) * std::max(0.0, height);
  const double either = a.width_px * a.height_px + b.width_px * b.height_px - both;
  return either > 0.0 ? both / either : 0.0;
}

inline Eigen::MatrixXd similarity_of(const std::vector<MotBox>& truth,
                                     const std::vector<MotBox>& run) {
  Eigen::MatrixXd similarity(std::ssize(truth), std::ssize(run));
  for (Eigen::Index i = 0; i < similarity.rows(); ++i)
    for (Eigen::Index j = 0; j < similarity.cols(); ++j)
      similarity(i, j) = intersection_over_union(truth[i], run[j]);
  return similarity;
}

/// A tracker's box that matches a distractor of the truth counts neither way, nor does truth that
/// is not a pedestrian or is marked as not to be scored.
inline TrackingFrame mot_frame(const std::vector<MotBox>& truth, std::vector<MotBox> run) {
  constexpr int kPedestrian = 1;
  constexpr int kDistractors[] = {2, 7, 8, 12};
  Eigen::MatrixXd similarity = similarity_of(truth, run);
  std::vector<double> cost;
  for (Eigen::Index i = 0; i < similarity.rows(); ++i)
    for (Eigen::Index j = 0; j < similarity.cols(); ++j)
      cost.push_back(similarity(i, j) < 0.5 ? 0.0 : -similarity(i, j));
  std::vector<bool> dropped(run.size());
  for (const AssignedPair& pair : assign(cost, truth.size(), run.size()))
    if (similarity(pair.row, pair.column) >= 0.5 &&
        std::ranges::find(kDistractors, truth[pair.row].kind) != std::end(kDistractors))
      dropped[pair.column] = true;
  std::vector<MotBox> kept_run, kept_truth;
  for (std::size_t j = 0; j < run.size(); ++j)
    if (!dropped[j]) kept_run.push_back(run[j]);
  for (const MotBox& box : truth)
    if (box.kind == kPedestrian && box.confidence != 0.0) kept_truth.push_back(box);
  TrackingFrame frame;
  for (const MotBox& box : kept_truth) frame.truth_ids.push_back(box.id);
  for (const MotBox& box : kept_run) frame.run_ids.push_back(box.id);
  frame.similarity = similarity_of(kept_truth, kept_run);
  return frame;
}

inline std::vector<TrackingFrame> mot_sequence(const std::filesystem::path& truth_file,
                                               const std::filesystem::path& run_file,
                                               int frame_count) {
  MotBoxes truth = read_mot(truth_file), run = read_mot(run_file);
  std::vector<TrackingFrame> frames;
  for (int frame = 1; frame <= frame_count; ++frame)
    frames.push_back(mot_frame(truth[frame], run[frame]));
  return frames;
}

}  // namespace vildar
