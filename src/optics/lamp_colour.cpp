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

}  // namespace

double tail_lamp_log_odds(double cr, double cb) {
  return log_density(cr, cb, kTail) - log_density(cr, cb, kHead);
}

}  // namespace vildar
