#include "detect/peaks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

namespace vildar {
namespace {

// Chamfer distances (Borgefors 1986): 3 per straight step, 4 per diagonal one.
constexpr int kStraight = 3;
constexpr int kDiagonal = 4;
constexpr int kNone = -1;
/// A neck narrower than this share of the smaller disc's half width parts two clipped discs.
constexpr double kNeckShare = 0.7;
/// The same against an area whose own lights are already taken out: what joins it is lost.
constexpr double kNeckShareOfRest = 0.95;
/// Pixels of one bright area that are looked at.
constexpr int kMostPixels = 1000;
/// The same where its greatest code fills more than that: a larger flat area is no lamp.
constexpr int kMostFlatPixels = 16000;

/// Sum of an area's codes above the threshold, in sigmas of that sum, that no noise reaches.
constexpr double kLeastExcessSigma = 5.0;

bool is_above_noise(const LumaView& luma, std::span<const int> run_indices,
                    const std::vector<PixelRun>& runs, int threshold_code, const PeakRules& rules) {
  constexpr int kEnough_px = 64;  // an area as large is no grain
  int pixels = 0, excess = 0;
  for (const int index : run_indices) {
    const PixelRun& run = runs[index];
    pixels += run.u_end - run.u_begin;
    if (pixels > kEnough_px) return true;
    for (int u = run.u_begin; u < run.u_end; ++u) excess += luma.code(u, run.v) - threshold_code;
  }
  return pixels >= rules.min_area_px &&
         excess >= kLeastExcessSigma * rules.noise_codes * std::sqrt(pixels);
}

/// The label of a set: its number from 1 on, and below it the number's complement. Of several
/// labels and 0s put together bit by bit, the two have a bit in common unless all labels are one.
std::uint64_t label_of(int set) {
  const auto number = static_cast<std::uint32_t>(set) + 1;
  return std::uint64_t{number} << 32 | static_cast<std::uint32_t>(~number);
}
std::uint32_t number_in(std::uint64_t label) { return static_cast<std::uint32_t>(label >> 32); }
int set_of(std::uint64_t label) { return static_cast<int>(number_in(label)) - 1; }

/// Whether a peak of height `top` stands clear of a valley of height `valley`.
bool stands_clear(int top, int valley, int clip_code, int least_valley_codes, double neck_share) {
  if (valley <= clip_code) return std::min(top, clip_code) - valley >= least_valley_codes;
  const int depth = top - clip_code, neck = valley - clip_code;
  return depth - neck >= kStraight && neck <= neck_share * depth;
}

}  // namespace

void PeakFinder::clear() {
  peaks_.clear();
  pixels_.clear();
}

int PeakFinder::root_of(int set) {
  while (sets_[set].parent != set) set = sets_[set].parent = sets_[sets_[set].parent].parent;
  return set;
}

void PeakFinder::close(int root, int valley_code, bool split, const PeakRules& rules) {
  Set& set = sets_[root];
  set.closed = true;
  if (set.count < rules.min_area_px && !split) return;
  Peak peak;
  peak.first = pixels_.size();
  peak.area_px = set.count;
  peak.split = split;
  peak.peak_code = std::min(set.top, rules.clip_code);
  // Where two clipped discs part at a neck, each keeps what its own depth reaches.
  const bool by_depth = valley_code >= rules.clip_code;
  const int level =
      by_depth ? valley_code + 1 : std::max(valley_code + 1, rules.half_code[peak.peak_code]);
  peak.level_code = std::min(level, rules.clip_code);
  if (by_depth) peak.eroded_px = (valley_code - rules.clip_code + 1) / kStraight;
  for (int at = set.first; at != kNone; at = nodes_[at].next) {
    const Node& node = nodes_[at];
    if (node.height < level) continue;
    if (peak.count == 0) peak.box = {node.u, node.v, node.u, node.v};
    peak.box.u_min = std::min(peak.box.u_min, node.u);
    peak.box.u_max = std::max(peak.box.u_max, node.u);
    peak.box.v_min = std::min(peak.box.v_min, node.v);
    peak.box.v_max = std::max(peak.box.v_max, node.v);
    peak.clipped_px += node.code >= rules.clip_code;
    peak.head |= node.foot;
    ++peak.count;
    pixels_.push_back({node.u, node.v});
  }
  if (peak.count > 0) peaks_.push_back(peak);
}

void PeakFinder::fill_depths(int clip_code) {
  // Two raster passes over the padded box; pixels off the plateau keep depth 0.
  const auto depth_from = [&](int cell, int direction) {
    const std::uint64_t* row = &grid_[cell + direction * grid_width_];
    return std::min({grid_[cell + direction] + kStraight, row[0] + kStraight, row[-1] + kDiagonal,
                     row[1] + kDiagonal});
  };
  for (const int node : plateau_) grid_[nodes_[node].cell] = depth_from(nodes_[node].cell, -1);
  std::for_each(plateau_.rbegin(), plateau_.rend(), [&](int node) {
    std::uint64_t& depth = grid_[nodes_[node].cell];
    depth = std::min(depth, depth_from(nodes_[node].cell, 1));
  });
  for (const int node : plateau_)
    nodes_[node].height = clip_code + static_cast<int>(std::exchange(grid_[nodes_[node].cell], 0));
}

void PeakFinder::sort_by_height() {
  const int n = static_cast<int>(nodes_.size());
  const auto lower = [](const Node& a, const Node& b) { return a.height < b.height; };
  const auto [lowest, highest] = std::minmax_element(nodes_.begin(), nodes_.end(), lower);
  const int least = lowest->height, most = highest->height;
  order_.resize(nodes_.size());
  if (most - least > 4 * n) {  // deep codes in a small area: counting would cost more
    std::iota(order_.begin(), order_.end(), 0);
    std::sort(order_.begin(), order_.end(), [&](int a, int b) {
      return nodes_[a].height != nodes_[b].height ? nodes_[a].height > nodes_[b].height : a < b;
    });
    return;
  }
  place_.assign(static_cast<std::size_t>(most - least) + 2, 0);
  for (const Node& node : nodes_) ++place_[most - node.height + 1];
  std::partial_sum(place_.begin(), place_.end(), place_.begin());
  for (int node = 0; node < n; ++node) order_[place_[most - nodes_[node].height]++] = node;
}

/// The least code, from the threshold to that of the plateau, that no more than kMostPixels reach;
/// where none does, the greatest that is reached, if by no more than kMostFlatPixels.
int PeakFinder::floor_code(const LumaView& luma, std::span<const int> run_indices,
                           const std::vector<PixelRun>& runs, int threshold_code,
                           const PeakRules& rules) {
  int pixels = 0;
  for (const int index : run_indices) pixels += runs[index].u_end - runs[index].u_begin;
  const auto more_reach = [&](int code, int most) {
    int count = 0;
    for (const int index : run_indices) {
      if (runs[index].most_code < code) continue;
      count += count_from(luma, runs[index], code);
      if (count > most) return true;
    }
    return false;
  };
  int below = threshold_code, floor = rules.clip_code - rules.least_valley_codes / 2;
  if (pixels <= kMostPixels || below >= floor) return threshold_code;
  while (floor - below > 1) {
    const int middle = std::midpoint(below, floor);
    (more_reach(middle, kMostPixels) ? below : floor) = middle;
  }
  return more_reach(floor, 0) || more_reach(below, kMostFlatPixels) ? floor : below;
}

void PeakFinder::load(const LumaView& luma, std::span<const int> run_indices,
                      const std::vector<PixelRun>& runs, int floor_code, const PeakRules& rules) {
  PixelBox box{luma.width_px, luma.height_px, -1, -1};
  for (const int index : run_indices) {
    const PixelRun& run = runs[index];
    box.u_min = std::min(box.u_min, run.u_begin);
    box.u_max = std::max(box.u_max, run.u_end - 1);
    box.v_min = std::min(box.v_min, run.v);
    box.v_max = std::max(box.v_max, run.v);
  }
  grid_width_ = box.u_max - box.u_min + 3;
  grid_.resize(std::max(grid_.size(), static_cast<std::size_t>(grid_width_) *
                                          static_cast<std::size_t>(box.v_max - box.v_min + 3)));
  nodes_.clear();
  plateau_.clear();
  clipped_.clear();
  const int clear_code = rules.clip_code - rules.least_valley_codes;
  // A little under the clipping code still counts as plateau: compression digs holes into it.
  const int plateau_code = rules.clip_code - rules.least_valley_codes / 2;
  for (const int index : run_indices) {
    const PixelRun& run = runs[index];
    if (run.most_code < floor_code) continue;
    const int row = (run.v - box.v_min + 1) * grid_width_ - box.u_min + 1;
    for_each_code(luma, run, [&](int u, int code) {
      if (code < floor_code) return;
      if (code > clear_code) {
        if (!clipped_.empty() && clipped_.back().v == run.v && clipped_.back().u_end == u)
          ++clipped_.back().u_end;
        else
          clipped_.push_back({run.v, u, u + 1});
      }
      if (code >= plateau_code) plateau_.push_back(static_cast<int>(nodes_.size()));
      nodes_.push_back({u, run.v, code, code, row + u, kNone, false});
      __builtin_prefetch(&grid_[row + u]);  // far from where it was used last
    });
  }
  if (rules.upright) cut_below_heads(rules);
  fill_depths(rules.clip_code);
}

/// Digs a valley below each head.
void PeakFinder::cut_below_heads(const PeakRules& rules) {
  const int valley = rules.clip_code - rules.least_valley_codes;
  const auto each_of = [&](const PixelRun& run, auto use) {
    auto node = std::partition_point(nodes_.begin(), nodes_.end(), [&](const Node& one) {
      return one.v != run.v ? one.v < run.v : one.u < run.u_begin;
    });
    for (; node != nodes_.end() && node->v == run.v && node->u < run.u_end; ++node) use(*node);
  };
  const std::vector<PixelRun>& cuts = heads_.cuts(clipped_);
  for (const PixelRun& cut : cuts) {
    each_of(cut, [&](Node& node) { node.height = std::min(node.height, valley); });
    each_of({cut.v - 1, cut.u_begin, cut.u_end}, [](Node& node) { node.foot = true; });
  }
  if (!cuts.empty())
    std::erase_if(plateau_, [&](int node) { return nodes_[node].height <= valley; });
}

int PeakFinder::join(int mine, int theirs, int height, const PeakRules& rules) {
  const bool mine_closed = sets_[mine].closed, theirs_closed = sets_[theirs].closed;
  const double neck_share = mine_closed || theirs_closed ? kNeckShareOfRest : kNeckShare;
  const auto clear = [&](int root) {
    return sets_[root].closed || stands_clear(sets_[root].top, height, rules.clip_code,
                                              rules.least_valley_codes, neck_share);
  };
  if (clear(mine) && clear(theirs)) {
    if (!mine_closed) close(mine, height, true, rules);
    if (!theirs_closed) close(theirs, height, true, rules);
  }
  if (sets_[theirs].top > sets_[mine].top) std::swap(mine, theirs);
  Set& kept = sets_[mine];
  Set& joined = sets_[theirs];
  nodes_[kept.last].next = joined.first;
  kept.last = joined.last;
  kept.count += joined.count;
  kept.closed |= joined.closed;
  joined.parent = mine;
  return mine;
}

/// The set that a node lower than all so far belongs to: that about it, those about it joined, or
/// one of its own. Few nodes have more than one about them.
int PeakFinder::set_about(int node, const PeakRules& rules) {
  const int row = grid_width_;
  const std::uint64_t* middle = &grid_[nodes_[node].cell];
  const std::uint64_t all = middle[-1] | middle[1] | middle[-row] | middle[row] | middle[-row - 1] |
                            middle[-row + 1] | middle[row - 1] | middle[row + 1];
  if (all == 0) {
    const int own = static_cast<int>(sets_.size());
    sets_.push_back({own, node, node, nodes_[node].height, 1, false});
    return own;
  }
  if ((number_in(all) & static_cast<std::uint32_t>(all)) != 0) return join_about(node, rules);
  const int mine = root_of(set_of(all));
  append(node, mine);
  return mine;
}

int PeakFinder::join_about(int node, const PeakRules& rules) {
  const int row = grid_width_;
  const std::uint64_t* middle = &grid_[nodes_[node].cell];
  const std::array<std::uint64_t, 8> about{middle[-1],      middle[1],        middle[-row],
                                           middle[row],     middle[-row - 1], middle[-row + 1],
                                           middle[row - 1], middle[row + 1]};
  int mine = root_of(set_of(*std::max_element(about.begin(), about.end())));
  append(node, mine);
  for (const std::uint64_t label : about) {
    if (label == 0) continue;
    const int theirs = root_of(set_of(label));
    if (theirs != mine) mine = join(mine, theirs, nodes_[node].height, rules);
  }
  return mine;
}

void PeakFinder::append(int node, int root) {
  Set& set = sets_[root];
  nodes_[set.last].next = node;
  set.last = node;
  ++set.count;
}

void PeakFinder::add(const LumaView& luma, std::span<const int> run_indices,
                     const std::vector<PixelRun>& runs, int threshold_code,
                     const PeakRules& rules) {
  if (!is_above_noise(luma, run_indices, runs, threshold_code, rules)) return;
  const int floor = floor_code(luma, run_indices, runs, threshold_code, rules);
  load(luma, run_indices, runs, floor, rules);
  if (nodes_.empty()) return;
  sort_by_height();
  sets_.clear();
  for (const int node : order_) grid_[nodes_[node].cell] = label_of(set_about(node, rules));
  for (const Node& node : nodes_) grid_[node.cell] = 0;
  // One set is left, or several where the floor has parted the area.
  for (int set = 0; set < static_cast<int>(sets_.size()); ++set)
    if (root_of(set) == set && !sets_[set].closed) close(set, floor - 1, false, rules);
}

}  // namespace vildar
