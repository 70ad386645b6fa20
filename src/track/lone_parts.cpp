#include "track/lone_parts.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "core/by_frame.h"

namespace vildar {
namespace {

using Frames = std::vector<SeenVehicle>;

constexpr double kShortly_s = 1.0;  // for which a pair vouches for what was seen after it

bool both_seen(const SeenVehicle& one) { return one.sighting.left && one.sighting.right; }
bool is_pair(const SeenVehicle& one) { return both_seen(one) && one.fits; }
double time_s(const SeenVehicle& one) { return seconds_of(one.sighting.time); }
double width_px(const PixelBox& box) { return box.u_max - box.u_min + 1.0; }

bool drawn_out(const LampSighting& lamp) {
  constexpr double kTall = 1.6;
  return lamp.box.v_max - lamp.box.v_min + 1.0 > kTall * width_px(lamp.box);
}

/// What a lamp was like where it was last seen as itself.
class Likeness {
 public:
  explicit Likeness(const LampSighting& lamp)
      : flux_ln_(flux_ln(lamp)), width_px_(width_px(lamp.box)) {}

  bool too_wide(const LampSighting& lamp) const {
    constexpr double kShare = 1.6, kGive_px = 1.0;
    return width_px(lamp.box) > kShare * width_px_ + kGive_px;
  }
  /// Of a lamp run together with its image on the road the light says nothing.
  bool of_other_light(const LampSighting& lamp) const {
    constexpr double kMostStepLn = 1.0;
    return !drawn_out(lamp) && std::abs(flux_ln(lamp) - flux_ln_) > kMostStepLn;
  }
  void learn(const LampSighting& lamp) {
    constexpr double kMemory = 0.3;
    if (!drawn_out(lamp)) flux_ln_ += kMemory * (flux_ln(lamp) - flux_ln_);
    width_px_ += kMemory * (width_px(lamp.box) - width_px_);
  }

 private:
  static double flux_ln(const LampSighting& lamp) { return std::log(std::max(lamp.flux, 1e-9)); }
  double flux_ln_, width_px_;
};

const LampSighting& only_lamp(const SeenVehicle& one) {
  return one.sighting.left ? *one.sighting.left : *one.sighting.right;
}

/// Going back from the first pair.
void drop_strangers_before(Frames& seen) {
  constexpr double kShortlyBefore_s = 3.0, kLongestGap_s = 0.5;
  const auto first = std::ranges::find_if(seen, is_pair);
  if (first == seen.end()) return;
  Likeness left(*first->sighting.left), right(*first->sighting.right);
  double until_s = time_s(*first);
  Frames kept;
  for (auto one = std::make_reverse_iterator(first); one != seen.rend(); ++one) {
    if (time_s(*first) - time_s(*one) > kShortlyBefore_s || until_s - time_s(*one) > kLongestGap_s)
      break;
    if (both_seen(*one)) continue;
    if (!one->sighting.both_in_one) {
      const LampSighting& lamp = only_lamp(*one);
      Likeness& then = one->sighting.left ? left : right;
      if (then.too_wide(lamp) || then.of_other_light(lamp)) continue;
      then.learn(lamp);
    }
    until_s = time_s(*one);
    kept.push_back(*one);
  }
  std::ranges::reverse(kept);
  seen.erase(seen.begin(), first);
  seen.insert(seen.begin(), kept.begin(), kept.end());
}

void drop_merged_later(Frames& seen) {
  std::optional<Likeness> left, right;
  std::erase_if(seen, [&](const SeenVehicle& one) {
    if (one.sighting.both_in_one) return false;
    if (is_pair(one)) {
      left ? left->learn(*one.sighting.left) : void(left.emplace(*one.sighting.left));
      right ? right->learn(*one.sighting.right) : void(right.emplace(*one.sighting.right));
      return false;
    }
    if (both_seen(one)) return true;
    const auto& then = one.sighting.left ? left : right;
    return then && then->too_wide(only_lamp(one));
  });
}

// A lamp left alone for long has lost what shows that it is still the vehicle's.
void drop_lone_tail(Frames& seen) {
  const auto last = std::find_if(seen.rbegin(), seen.rend(), is_pair);
  if (last == seen.rend()) return;
  const double until_s = time_s(*last) + kShortly_s;
  std::erase_if(
      seen, [&](const auto& one) { return time_s(one) > until_s && !one.sighting.both_in_one; });
}

// A short time as a pair does not vouch for a long one as a lone light, which in a queue may have
// been the glare of others: what is farthest from the pair goes first.
void drop_what_no_pair_vouches_for(Frames& seen, double least_share) {
  const auto pairs = static_cast<double>(std::ranges::count_if(seen, is_pair));
  const auto lone_before = std::ranges::find_if(seen, is_pair) - seen.begin();
  const auto spare = std::ssize(seen) - static_cast<std::ptrdiff_t>(pairs / least_share);
  if (spare > 0) seen.erase(seen.begin(), seen.begin() + std::min(spare, lone_before));
}

// Long away from those in a row, one pair is two lights that stood so by chance.
void doubt_single_pairs(Frames& seen) {
  std::vector<SeenVehicle*> pairs;
  for (SeenVehicle& one : seen)
    if (is_pair(one)) pairs.push_back(&one);
  const auto far = [&](std::size_t i, std::size_t j) {
    return j >= pairs.size() || std::abs(time_s(*pairs[i]) - time_s(*pairs[j])) > kShortly_s;
  };
  std::vector<std::size_t> alone;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (far(i, i - 1) && far(i, i + 1)) alone.push_back(i);
  if (alone.size() == pairs.size()) return;
  for (const std::size_t i : alone) pairs[i]->fits = false;
}

}  // namespace

void drop_strange_parts(Frames& seen, double least_pair_share) {
  doubt_single_pairs(seen);
  drop_strangers_before(seen);
  drop_merged_later(seen);
  drop_lone_tail(seen);
  drop_what_no_pair_vouches_for(seen, least_pair_share);
}

bool keep_longest_pair(std::vector<LampRecord>& left, std::vector<LampRecord>& right) {
  constexpr double kStepLn = 0.7, kStep_px = 6.0, kAtOnce_s = 0.2, kGoesOn_s = 0.7, kMost = 0.6;
  struct Look {
    std::int64_t frame;
    double time_s, apart_px;
  };
  std::vector<Look> looks;
  for_each_common_frame(
      left, right, &LampRecord::frame, [&](const LampRecord& a, const LampRecord& b) {
        looks.push_back({a.frame, seconds_of(a.time), (b.at_px - a.at_px).norm()});
      });
  const auto within = [](const Look& one, const Look& next, double most_s) {
    return next.time_s - one.time_s < most_s;
  };
  const auto unlike = [](const Look& one, const Look& next) {
    return std::abs(next.apart_px - one.apart_px) > kStep_px &&
           std::abs(std::log(next.apart_px / one.apart_px)) > kStepLn;
  };
  std::vector<std::span<const Look>> pieces;
  for (auto begin = looks.begin(); begin != looks.end();) {
    const auto step =
        std::adjacent_find(begin, looks.end(), [&](const Look& one, const Look& next) {
          return within(one, next, kAtOnce_s) && unlike(one, next);
        });
    const auto end = step == looks.end() ? step : std::next(step);
    pieces.emplace_back(begin, end);
    begin = end;
  }
  if (pieces.size() < 2) return true;
  const auto size = [](const auto& piece) { return piece.size(); };
  auto first = std::ranges::max_element(pieces, {}, size), last = first;
  std::vector<char> kept(pieces.size(), 0);
  const auto keep = [&](auto piece) { kept[static_cast<std::size_t>(piece - pieces.begin())] = 1; };
  const auto goes_on = [&](const auto& one, const auto& next) {
    return within(one.back(), next.front(), kGoesOn_s) && !unlike(one.back(), next.front());
  };
  keep(first);
  for (auto piece = std::next(last); piece != pieces.end(); ++piece)
    if (goes_on(*last, *piece)) keep(last = piece);
  for (auto piece = first; piece != pieces.begin();)
    if (goes_on(*--piece, *first)) keep(first = piece);
  std::size_t kept_looks = 0;
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    if (kept[k]) {
      kept_looks += pieces[k].size();
      continue;
    }
    for (auto* records : {&left, &right})
      std::erase_if(*records, [&](const LampRecord& record) {
        return (k == 0 || record.frame >= pieces[k].front().frame) &&
               (k + 1 == pieces.size() || record.frame <= pieces[k].back().frame);
      });
  }
  return static_cast<double>(kept_looks) > kMost * static_cast<double>(looks.size());
}

}  // namespace vildar
