#include "estimate/light_edges.h"

#include <algorithm>
#include <cmath>

namespace vildar {
namespace {

// Blocks over which a change is told from those before and after it.
constexpr std::ptrdiff_t kReach = 2;
constexpr double kSteeper = 2.5, kClearEdgeSigmas = 10.0;

// Whether the light changes between a block and the second after it as no curve does that is wider
// than a block.
bool is_edge(const std::vector<PowerBlock>& blocks, std::ptrdiff_t from) {
  const auto last = static_cast<std::ptrdiff_t>(blocks.size()) - 1;
  const auto at = [&](std::ptrdiff_t i) -> const PowerBlock& {
    return blocks[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i, 0, last))];
  };
  const PowerBlock &before = at(from), &after = at(from + kReach);
  if (after.time_s - before.time_s > (kReach + 0.5) * before.duration_s) return false;
  const double change_w = std::abs(after.power_w - before.power_w);
  const double around_w = std::abs(before.power_w - at(from - kReach).power_w) +
                          std::abs(at(from + 2 * kReach).power_w - after.power_w);
  return change_w >
         kSteeper * around_w + kClearEdgeSigmas * std::hypot(before.sigma_w, after.sigma_w);
}

// Whether the last block may hold part of an edge, which the end of the blocks hides: it leaves
// what leads to it.
bool ends_in_an_edge(const std::vector<PowerBlock>& blocks) {
  if (blocks.size() < 3) return false;
  const PowerBlock &last = blocks.back(), &before = *(blocks.end() - 2),
                   &first = *(blocks.end() - 3);
  return std::abs(last.power_w - before.power_w) >
         kSteeper * std::abs(before.power_w - first.power_w) +
             kClearEdgeSigmas * std::hypot(last.sigma_w, before.sigma_w);
}

// Marks the blocks in which an edge of `finer` may lie.
void touch(const std::vector<PowerBlock>& finer, const std::vector<PowerBlock>& blocks,
           std::vector<bool>& touched) {
  std::size_t block = 0;
  for (std::ptrdiff_t i = 0; i + kReach < static_cast<std::ptrdiff_t>(finer.size()); ++i) {
    if (!is_edge(finer, i)) continue;
    const double from_s = finer[static_cast<std::size_t>(i)].time_s;
    const double to_s = finer[static_cast<std::size_t>(i + kReach)].time_s;
    const auto ends_s = [](const PowerBlock& one) { return one.time_s + 0.5 * one.duration_s; };
    while (block < blocks.size() && ends_s(blocks[block]) < from_s) ++block;
    for (std::size_t k = block; k < blocks.size(); ++k) {
      if (blocks[k].time_s - 0.5 * blocks[k].duration_s > to_s) break;
      touched[k] = true;
    }
  }
}

}  // namespace

void keep_between_edges(std::vector<PowerBlock>& blocks, double ambient_w,
                        const std::vector<PowerBlock>& finer) {
  std::vector<bool> touched(blocks.size(), false);
  touch(blocks, blocks, touched);
  touch(finer, blocks, touched);
  if (ends_in_an_edge(blocks)) touched.back() = true;
  std::size_t best_first = 0, best_last = 0;
  double most_w = 0.0;
  for (std::size_t first = 0; first < blocks.size();) {
    std::size_t last = first;
    double light_w = 0.0;
    for (; last < blocks.size() && !touched[last]; ++last)
      light_w += blocks[last].power_w - ambient_w;
    if (light_w > most_w) {
      most_w = light_w;
      best_first = first;
      best_last = last;
    }
    first = last + 1;
  }
  blocks.erase(blocks.begin() + static_cast<std::ptrdiff_t>(best_last), blocks.end());
  blocks.erase(blocks.begin(), blocks.begin() + static_cast<std::ptrdiff_t>(best_first));
}

}  // namespace vildar
