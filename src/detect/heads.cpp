#include "detect/heads.h"

#include <algorithm>

namespace vildar {
namespace {

constexpr int kLeast_px = 3;  // rows and columns of a lamp
/// A disc that ran into its like beside it has come to half its width by then; one that stands free
/// for more of it has light of another shape below.
constexpr double kStandingShare = 0.6;
constexpr double kDrawnOut = 1.5;
/// What a head widens by where it runs into the light on the road.
constexpr int kWider = 2;
constexpr int kLeastRowsOfOther = 2;

}  // namespace

int HeadFinder::root_of(int head) {
  while (heads_[head].parent != head)
    head = heads_[head].parent = heads_[heads_[head].parent].parent;
  return head;
}

/// The head of run `at`, below the runs `above_`.
int HeadFinder::join(std::span<const PixelRun> runs, int at) {
  const PixelRun& run = runs[at];
  const int width_px = run.u_end - run.u_begin;
  const int fresh = static_cast<int>(heads_.size());
  if (above_.empty()) {
    heads_.push_back({fresh, run.v, width_px, false});
    return fresh;
  }
  const auto rows = [&](const Head& head) { return run.v - head.first_v; };
  const auto stands = [&](const Head& head) {
    return !head.trunk && head.width_px >= kLeast_px && rows(head) >= kLeast_px &&
           rows(head) >= kStandingShare * head.width_px;
  };
  // Whether what else meets here is a reason to cut this one off.
  const auto meets_other = [&](int mine) {
    const Head& head = heads_[mine];
    return std::any_of(above_.begin(), above_.end(), [&](int run_above) {
      const int theirs = root_of(head_of_[run_above]);
      if (theirs == mine) return false;
      const Head& other = heads_[theirs];
      return other.trunk || stands(other) ||
             (rows(head) >= kDrawnOut * head.width_px && rows(other) >= kLeastRowsOfOther);
    });
  };
  bool trunk = false;
  for (const int run_above : above_) {
    const int mine = root_of(head_of_[run_above]);
    const Head& head = heads_[mine];
    if (!stands(head) || !(width_px >= kWider * head.width_px || meets_other(mine))) continue;
    const PixelRun& last = runs[run_above];
    cuts_.push_back(
        {run.v, std::max(run.u_begin, last.u_begin - 1), std::min(run.u_end, last.u_end + 1)});
    trunk = true;
  }
  if (trunk) {
    heads_.push_back({fresh, run.v, width_px, true});
    for (const int run_above : above_) heads_[root_of(head_of_[run_above])].parent = fresh;
    return fresh;
  }
  const int kept = root_of(head_of_[above_.front()]);
  for (const int run_above : above_) {
    const int other = root_of(head_of_[run_above]);
    if (other == kept) continue;
    heads_[kept].first_v = std::min(heads_[kept].first_v, heads_[other].first_v);
    heads_[kept].width_px = std::max(heads_[kept].width_px, heads_[other].width_px);
    heads_[kept].trunk |= heads_[other].trunk;
    heads_[other].parent = kept;
  }
  heads_[kept].width_px = std::max(heads_[kept].width_px, width_px);
  return kept;
}

const std::vector<PixelRun>& HeadFinder::cuts(std::span<const PixelRun> runs) {
  heads_.clear();
  cuts_.clear();
  head_of_.resize(runs.size());
  int first_above = 0;  // run that may touch the present one
  int row_start = 0;    // first run of the present row
  for (int i = 0; i < static_cast<int>(runs.size()); ++i) {
    if (i > 0 && runs[i].v != runs[i - 1].v) {
      first_above = runs[i - 1].v == runs[i].v - 1 ? row_start : i;
      row_start = i;
    }
    while (first_above < row_start && runs[first_above].u_end < runs[i].u_begin) ++first_above;
    above_.clear();
    for (int j = first_above; j < row_start && runs[j].u_begin <= runs[i].u_end; ++j)
      above_.push_back(j);
    head_of_[i] = join(runs, i);
  }
  return cuts_;
}

}  // namespace vildar
