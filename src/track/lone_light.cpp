#include "track/lone_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/median.h"

namespace vildar {
namespace {

// Of all lights that stay alone and move along the road, one in five is a lamp.
constexpr double kPriorLogOdds = -1.4;
// Looks at a light are not independent: however many, they count as so many.
constexpr double kFacts = 3.0;

struct Chance {
  double lamp, glint;
};
constexpr Chance kRides{0.1, 0.6}, kIsMirrored{0.05, 0.25}, kIsBelow{0.1, 0.4},
    kIsMisshapen{0.05, 0.35}, kIsUnlike{0.03, 0.25}, kClips{0.9, 0.6}, kIsImaged{0.6, 0.2},
    kIsUnseen{0.07, 0.3}, kIsPaired{0.1, 0.6}, kIsOffCourse{0.15, 0.45};

struct Spread {
  double mean, sigma;
};
// Of ln strength about that of strong lamps.
constexpr Spread kLampLn{-0.4, 0.8}, kGlintLn{-1.5, 1.0};
constexpr double kDimShare = 0.1;  // of lamps: a bicycle's, and others as dim as glints
// High beams over low beams, and how sharply more than that is too much.
constexpr double kStrongestLn = 2.3, kStrongestSigmaLn = 0.4;

double log_odds_of_share(double share, Chance chance) {
  return kFacts * (share * std::log(chance.lamp / chance.glint) +
                   (1.0 - share) * std::log((1.0 - chance.lamp) / (1.0 - chance.glint)));
}

double width_px_of(const LampRecord& record) {
  const PixelBox& box = record.sighting.box;
  return box.u_max - box.u_min + 1.0;
}

// Of a lamp overexposed so far that its lens' halo clips, too.
bool glares(const LampRecord& record) {
  constexpr double kRound = 1.35, kLeastClipped = 0.3;
  const PixelBox& box = record.sighting.box;
  const double width_px = width_px_of(record), height_px = box.v_max - box.v_min + 1.0;
  return std::max(width_px, height_px) < kRound * std::min(width_px, height_px) &&
         record.sighting.saturated_px > kLeastClipped * width_px * height_px;
}

// A halo stays as wide as it is while the lamp comes nearer; what is wide grows.
bool grows_less_than_it_nears(std::span<const LampRecord> records, const RoadView& view) {
  constexpr std::size_t kLooks = 5;
  constexpr double kLeastNearerLn = 0.3, kMostShare = 0.5;
  if (records.size() < 2 * kLooks) return false;
  const auto grown_ln = [&](const auto& size_of) {
    std::vector<double> before, after;
    for (std::size_t i = 0; i < kLooks; ++i) {
      before.push_back(size_of(records[i]));
      after.push_back(size_of(records[records.size() - 1 - i]));
    }
    return std::log(median(std::move(after)) / median(std::move(before)));
  };
  const double nearer_ln = grown_ln(
      [&](const LampRecord& record) { return view.place(record.at_px).inverse_depth_per_m; });
  return std::abs(nearer_ln) > kLeastNearerLn && grown_ln(width_px_of) / nearer_ln < kMostShare;
}

double log_density(double value, Spread spread) {
  const double off = (value - spread.mean) / spread.sigma;
  return -0.5 * off * off - std::log(spread.sigma);
}

double log_odds_of_strength(double strength_ln) {
  const double odds =
      std::exp(log_density(strength_ln, kLampLn) - log_density(strength_ln, kGlintLn));
  return std::log((1.0 - kDimShare) * odds + kDimShare);
}

}  // namespace

double lone_lamp_log_odds(const LoneLight& light) {
  double log_odds = kPriorLogOdds + log_odds_of_share(light.riding_share, kRides) +
                    log_odds_of_share(light.mirrored_share, kIsMirrored) +
                    log_odds_of_share(light.misshapen_share, kIsMisshapen) +
                    log_odds_of_share(light.unlike_share, kIsUnlike);
  // To have an image speaks for a lamp, for dry roads show none, and not to be seen against one.
  log_odds += kFacts * light.imaged_share * std::log(kIsImaged.lamp / kIsImaged.glint);
  log_odds += kFacts * light.unseen_share * std::log(kIsUnseen.lamp / kIsUnseen.glint);
  // So does the time as one of a pair, which may have been its vehicle after all.
  log_odds += kFacts * light.paired_share * std::log(kIsPaired.lamp / kIsPaired.glint);
  log_odds += kFacts * light.off_course_share * std::log(kIsOffCourse.lamp / kIsOffCourse.glint);
  // To stand in no other's column does not speak for one: glints on bodies do not either.
  log_odds += std::fmin(0.0, log_odds_of_share(light.below_share, kIsBelow));
  // To clip speaks for a lamp anywhere; not to clip against it only where lamps do.
  log_odds += light.lamps_clip
                  ? log_odds_of_share(light.clipped_share, kClips)
                  : kFacts * light.clipped_share * std::log(kClips.lamp / kClips.glint);
  // Stronger than strong lamps is as good as strong: a high beam. Far stronger than that are
  // several lamps in one, or what they light.
  if (light.strength_ln) {
    log_odds += log_odds_of_strength(std::fmin(*light.strength_ln, kLampLn.mean));
    const double beyond = std::fmax(0.0, *light.strength_ln - kStrongestLn) / kStrongestSigmaLn;
    log_odds -= 0.5 * beyond * beyond;
  }
  return log_odds;
}

bool wider_than_a_lamp(const LampRecord& record, double inverse_depth_per_m, const RoadView& view) {
  constexpr double kWide_m = 1.0, kWide_px = 10.0;
  return width_px_of(record) > std::max(kWide_px, kWide_m * inverse_depth_per_m * view.focal_px());
}

double misshapen_share(std::span<const LampRecord> records, const RoadView& view) {
  constexpr std::ptrdiff_t kBeside = 2;  // records before and after
  constexpr double kMostStep = 1.4, kLeastStep_px = 2.0;
  const auto width_px = [&](std::ptrdiff_t i) {
    return width_px_of(records[static_cast<std::size_t>(i)]);
  };
  const bool may_glare = grows_less_than_it_nears(records, view);
  std::ptrdiff_t misshapen = 0;
  for (std::ptrdiff_t i = 0; i < std::ssize(records); ++i) {
    std::array<double, 2 * kBeside + 1> near_px{};
    for (std::ptrdiff_t j = -kBeside; j <= kBeside; ++j)
      near_px[static_cast<std::size_t>(j + kBeside)] =
          width_px(std::clamp<std::ptrdiff_t>(i + j, 0, std::ssize(records) - 1));
    std::ranges::nth_element(near_px, near_px.begin() + kBeside);
    const double usual_px = near_px[kBeside], own_px = width_px(i);
    const LampRecord& record = records[static_cast<std::size_t>(i)];
    const bool step = std::abs(own_px - usual_px) >= kLeastStep_px &&
                      std::max(own_px / usual_px, usual_px / own_px) > kMostStep;
    misshapen +=
        step || (!(may_glare && glares(record)) &&
                 wider_than_a_lamp(record, view.place(record.at_px).inverse_depth_per_m, view));
  }
  return records.empty() ? 0.0
                         : static_cast<double>(misshapen) / static_cast<double>(records.size());
}

}  // namespace vildar
