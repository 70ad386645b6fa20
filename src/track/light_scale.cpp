#include "track/light_scale.h"

#include <algorithm>

namespace vildar {
namespace {

constexpr std::size_t kFewest = 3, kMost = 32;

}  // namespace

void LightScale::add(LampKind kind, double strength, bool clips) {
  Memory& memory = kind == LampKind::taillamp ? tail_ : head_;
  if (memory.strengths.size() < kMost) {
    memory.strengths.push_back(strength);
    memory.clips.push_back(clips);
    return;
  }
  memory.strengths[memory.next] = strength;
  memory.clips[memory.next] = clips;
  memory.next = (memory.next + 1) % kMost;
}

std::optional<double> LightScale::typical(LampKind kind) const {
  const auto upper_quartile = [](std::vector<double> strengths) -> std::optional<double> {
    if (strengths.size() < kFewest) return std::nullopt;
    const auto upper = strengths.begin() + static_cast<std::ptrdiff_t>(3 * strengths.size() / 4);
    std::nth_element(strengths.begin(), upper, strengths.end());
    return *upper;
  };
  const std::optional<double> tail = upper_quartile(tail_.strengths);
  if (kind == LampKind::taillamp) return tail;
  return std::max(upper_quartile(head_.strengths), tail);
}

bool LightScale::usually_clips(LampKind kind) const {
  const std::vector<char>& clips = of(kind).clips;
  const auto clipping = std::count(clips.begin(), clips.end(), 1);
  return clips.size() >= kFewest && 2 * clipping > static_cast<std::ptrdiff_t>(clips.size());
}

}  // namespace vildar
