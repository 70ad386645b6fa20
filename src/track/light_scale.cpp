#include "track/light_scale.h"

#include <algorithm>
#include <cmath>

#include "core/median.h"
#include "optics/lamp_colour.h"

namespace vildar {
namespace {

constexpr std::size_t kFewest = 3, kMost = 32;

std::optional<double> upper_quartile(std::vector<double> strengths, std::size_t fewest) {
  if (strengths.size() < fewest) return std::nullopt;
  const auto upper = strengths.begin() + static_cast<std::ptrdiff_t>(3 * strengths.size() / 4);
  std::nth_element(strengths.begin(), upper, strengths.end());
  return *upper;
}

}  // namespace

void LightScale::add(LampKind kind, double strength, double slope_down, bool clips) {
  Memory& memory = kind == LampKind::taillamp ? tail_ : head_;
  if (memory.strengths.size() < kMost) {
    memory.strengths.push_back(strength);
    memory.slopes_down.push_back(slope_down);
    memory.clips.push_back(clips);
    return;
  }
  memory.strengths[memory.next] = strength;
  memory.slopes_down[memory.next] = slope_down;
  memory.clips[memory.next] = clips;
  memory.next = (memory.next + 1) % kMost;
}

void LightScale::see_colour(double cr, double cb) {
  colour_sum_ += std::hypot(cr, cb);
  red_ += tail_lamp_log_odds(cr, cb) > 0.0;
  ++lights_;
}

bool LightScale::colourless() const {
  constexpr double kNearGrey = 0.002, kSeldomRed = 0.005;
  return colour_sum_ < kNearGrey * lights_ && red_ < kSeldomRed * lights_;
}

std::optional<double> LightScale::typical(LampKind kind) const {
  const auto tail = upper_quartile(tail_.strengths, kFewest);
  if (kind == LampKind::taillamp) return tail;
  return std::max(upper_quartile(head_.strengths, kFewest), tail);
}

bool LightScale::knows(LampKind kind) const { return of(kind).strengths.size() >= kFewest; }

std::optional<double> LightScale::at_least(LampKind kind) const {
  constexpr double kFewDifferLn = 1.0;
  if (const auto known = typical(kind)) return known;
  const auto few = upper_quartile(of(kind).strengths, 1);
  return few ? std::optional(*few - kFewDifferLn) : std::nullopt;
}

double LightScale::dimmer_ln(double slope_down, LampKind kind) const {
  // From 3 to 30 degrees a factor of 39. The low beam of optics/beam_shapes.h loses 25 straight up,
  // but a mast stands aside as well, where it loses more, and lamps differ.
  constexpr double kFromSlope = 0.05, kPower = 1.5;
  if (kind != LampKind::headlamp) return 0.0;
  const std::vector<double>& told = head_.slopes_down;
  const double typical = told.size() < kFewest ? kFromSlope : std::max(kFromSlope, median(told));
  return slope_down > typical ? kPower * std::log(slope_down / typical) : 0.0;
}

bool LightScale::usually_clips(LampKind kind) const {
  const std::vector<char>& clips = of(kind).clips;
  const auto clipping = std::count(clips.begin(), clips.end(), 1);
  return clips.size() >= kFewest && 2 * clipping > static_cast<std::ptrdiff_t>(clips.size());
}

}  // namespace vildar
