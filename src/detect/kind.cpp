#include "detect/kind.h"

#include <algorithm>
#include <cmath>

#include "detect/run_scan.h"
#include "optics/lamp_colour.h"

namespace vildar {
namespace {

/// A lamp outshines what surrounds it at least so many times. A clipped one is brighter than it
/// shows, and may stand in the glare of another.
constexpr double kLeastContrast = 6.0;
constexpr double kLeastContrastClipped = 2.5;
/// What is red enough is no light on paint or bodies.
constexpr double kLeastContrastRed = 1.6;
/// A lamp seen as large as this is near, and a near lamp is no dimmer than this, but for red ones,
/// which are as round as their image on the road is not.
constexpr double kWideSpread_px = 5.0;
constexpr double kWideLeastPeak = 0.25;
constexpr double kRound = 1.3;
/// Unclipped lights longer than this are paint, kerbs and edges; red ones may be strips of LEDs.
constexpr double kMostElongation = 3.0, kMostElongationRed = 8.0;

}  // namespace

RimColour rim_colour(const Frame& frame, const PixelBox& box, int level_code, int clip_code) {
  const ChromaView& chroma = frame.chroma;
  if (!chroma.present()) return {};
  const LumaView& luma = frame.luma;
  const int u_from = std::max(box.u_min - 2, 0), u_to = std::min(box.u_max + 2, luma.width_px - 1);
  const int v_from = std::max(box.v_min - 2, 0), v_to = std::min(box.v_max + 2, luma.height_px - 1);
  std::int64_t n = 0, cr_codes = 0, cb_codes = 0, luma_codes = 0;
  for (int v = v_from; v <= v_to; ++v) {
    const PixelRun row{v, u_from, u_to + 1};
    if (brightest_of(luma, row) < level_code) continue;
    for_each_code(luma, row, [&](int u, int code) {
      if (code < level_code || code >= clip_code) return;
      cr_codes += chroma.cr_code(u, v);
      cb_codes += chroma.cb_code(u, v);
      luma_codes += code;
      ++n;
    });
  }
  if (n == 0) return {};
  const double scale = 1 << chroma.bit_depth;
  const auto mean_fraction = [&](std::int64_t codes) {
    return static_cast<double>(2 * codes - (n << chroma.bit_depth)) / (2.0 * scale) /
           static_cast<double>(n);
  };
  return {true, mean_fraction(cr_codes), mean_fraction(cb_codes),
          static_cast<double>(luma_codes) / static_cast<double>(n)};
}

RimColour own_colour(const RimColour& rim, int background_code, int clip_code) {
  constexpr double kBright = 0.4, kDimmest = 0.2;
  constexpr double kChance = 0.02;  // of a colour difference
  if (!rim.known) return rim;
  const double share =
      std::clamp((rim.luma_code - background_code) / (kBright * clip_code), kDimmest, 1.0);
  const double chance = kChance * std::sqrt(1.0 / (share * share) - 1.0);
  const double gain = colour_kept(chance) / share;
  return {true, gain * rim.cr, gain * rim.cb, rim.luma_code, chance};
}

bool like_a_lamp(const Peak& peak, const Measured& light, double peak_linear, double red_log_odds,
                 double px_per_usual) {
  const bool clipped = peak.clipped_px > 0;
  if (clipped && peak.head) return true;  // about it there may be nothing but what clips as well
  double contrast = clipped ? kLeastContrastClipped : kLeastContrast;
  const bool red = red_log_odds > kSurelyRed;
  if (red) contrast = kLeastContrastRed;
  if (peak_linear < contrast * light.background) return false;
  if (light.spread_px.maxCoeff() > kWideSpread_px * px_per_usual && peak_linear < kWideLeastPeak &&
      !(red && light.elongation < kRound))
    return false;
  return clipped || light.elongation <= (red ? kMostElongationRed : kMostElongation);
}

LampKind kind_of(const Peak& peak, const Measured& light, double peak_linear, const RimColour& rim,
                 double px_per_usual) {
  const double red_log_odds = rim.known ? tail_lamp_log_odds(rim.cr, rim.cb) : 0.0;
  if (!like_a_lamp(peak, light, peak_linear, red_log_odds, px_per_usual)) return LampKind::other;
  return red_log_odds > 0.0 ? LampKind::taillamp : LampKind::headlamp;
}

}  // namespace vildar
