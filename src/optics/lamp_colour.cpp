#include "optics/lamp_colour.h"

#include <algorithm>
#include <cmath>

namespace vildar {
namespace {

// Normal densities over (Cr, Cb), by their standard deviations along the line from blue to yellow,
// on which headlamps differ from one another (LED to halogen under sodium light), and across it.
struct Colour {
  double cr, cb, along_sigma, across_sigma;
};
constexpr Colour kHead{0.012, -0.015, 0.06, 0.022}, kTail{0.12, -0.05, 0.05, 0.045};
constexpr double kYellowCr = 0.6, kYellowCb = -0.8;  // a unit vector

double along_of(double cr, double cb) { return cr * kYellowCr + cb * kYellowCb; }
double across_of(double cr, double cb) { return cb * kYellowCr - cr * kYellowCb; }

// Yellower than tail lamps and greener than headlamps is no nearer to red, though the density of
// tail lamps has more there.
double log_density(double cr, double cb, const Colour& colour) {
  const double along =
      (std::min(along_of(cr, cb), along_of(kTail.cr, kTail.cb)) - along_of(colour.cr, colour.cb)) /
      colour.along_sigma;
  const double across = (std::max(across_of(cr, cb), across_of(kHead.cr, kHead.cb)) -
                         across_of(colour.cr, colour.cb)) /
                        colour.across_sigma;
  return -0.5 * (along * along + across * across) -
         std::log(colour.along_sigma * colour.across_sigma);
}

Colour blurred(Colour colour, double by) {
  colour.along_sigma = std::hypot(colour.along_sigma, by);
  colour.across_sigma = std::hypot(colour.across_sigma, by);
  return colour;
}

}  // namespace

double tail_lamp_log_odds(double cr, double cb) {
  return log_density(cr, cb, kTail) - log_density(cr, cb, kHead);
}

double colour_kept(double chance) {
  constexpr double kLampsDiffer = 0.1;  // in either colour difference
  return kLampsDiffer * kLampsDiffer / (kLampsDiffer * kLampsDiffer + chance * chance);
}

double faint_tail_lamp_log_odds(double cr, double cb, double chance) {
  const double kept = colour_kept(chance);
  return log_density(cr / kept, cb / kept, blurred(kTail, chance)) -
         log_density(cr / kept, cb / kept, blurred(kHead, chance));
}

bool colour_tells(double cr, double cb, double chance) {
  constexpr double kSureLogOdds = 1.1;  // 3 to 1
  return chance < kHead.across_sigma ||
         std::abs(faint_tail_lamp_log_odds(cr, cb, chance)) > kSureLogOdds;
}

}  // namespace vildar
