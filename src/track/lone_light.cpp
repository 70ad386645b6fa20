#include "track/lone_light.h"

#include <cmath>

namespace vildar {
namespace {

// Of all lights that stay alone and move along the road, one in five is a lamp.
constexpr double kPriorLogOdds = -1.4;
// Looks at a light are not independent: however many, they count as so many.
constexpr double kFacts = 3.0;

struct Chance {
  double lamp, glint;
};
constexpr Chance kRides{0.1, 0.6}, kIsMirrored{0.05, 0.25}, kClips{0.9, 0.6};

struct Spread {
  double mean, sigma;
};
// Of ln strength about that of strong lamps.
constexpr Spread kLampLn{-0.4, 0.8}, kGlintLn{-1.5, 1.0};
// High beams over low beams, and how sharply more than that is too much.
constexpr double kStrongestLn = 2.3, kStrongestSigmaLn = 0.4;

double log_odds_of_share(double share, Chance chance) {
  return kFacts * (share * std::log(chance.lamp / chance.glint) +
                   (1.0 - share) * std::log((1.0 - chance.lamp) / (1.0 - chance.glint)));
}

double log_density(double value, Spread spread) {
  const double off = (value - spread.mean) / spread.sigma;
  return -0.5 * off * off - std::log(spread.sigma);
}

}  // namespace

double lone_lamp_log_odds(const LoneLight& light) {
  double log_odds = kPriorLogOdds + log_odds_of_share(light.riding_share, kRides) +
                    log_odds_of_share(light.mirrored_share, kIsMirrored);
  // To clip speaks for a lamp anywhere; not to clip against it only where lamps do.
  log_odds += light.lamps_clip
                  ? log_odds_of_share(light.clipped_share, kClips)
                  : kFacts * light.clipped_share * std::log(kClips.lamp / kClips.glint);
  // Stronger than strong lamps is as good as strong: a high beam. Far stronger than that are
  // several lamps in one, or what they light.
  if (light.strength_ln) {
    const double strength_ln = std::fmin(*light.strength_ln, kLampLn.mean);
    log_odds += log_density(strength_ln, kLampLn) - log_density(strength_ln, kGlintLn);
    const double beyond = std::fmax(0.0, *light.strength_ln - kStrongestLn) / kStrongestSigmaLn;
    log_odds -= 0.5 * beyond * beyond;
  }
  return log_odds;
}

}  // namespace vildar
