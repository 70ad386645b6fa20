#include "detect/lamp_meter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/quantity.h"

namespace vildar {
namespace {

constexpr double kMostRim_px = 45.0;
/// A lamp of the last frame within this share of the way to the next lamp is the same one.
constexpr double kSameShare = 0.4;
constexpr double kMostMove_px = 25.0;
/// A fit that goes further than this from where the light was seen has found something else.
constexpr double kMostShift_px = 1.5;
constexpr double kMostShiftShare = 0.3;  // of the light's spread
constexpr double kLeastKnown = 0.3;      // relative sigma of a flux that is worth having
/// A lamp starts from the radius of the last frame, and every so many frames from anew.
constexpr int kLooks = 16;

double rim_of(const Peak& peak) {
  return peak.clipped_px > 0 ? std::sqrt(peak.clipped_px / kPi) + peak.eroded_px : 0.0;
}

bool near(const LampFit& lamp, const Measured& seen) {
  return (lamp.centre_px - seen.centre_px).norm() <=
         kMostShift_px + kMostShiftShare * seen.spread_px.maxCoeff();
}

}  // namespace

LampMeter::LampMeter(const PsfSite& psf, std::optional<double> exposure_s)
    : fitter_(psf.shape, psf.wing_share_std),
      core_sigma_px_(psf.shape.core_sigma_px),
      exposure_s_(exposure_s) {}

// Joins lamps that share pixels, the nearest first, as far as they can be fitted together.
void LampMeter::find_groups(const std::vector<Peak>& peaks, const std::vector<Measured>& lights) {
  struct Link {
    double share;
    std::size_t a, b;
  };
  const std::size_t n = lamps_.size();
  group_of_.resize(n);
  std::iota(group_of_.begin(), group_of_.end(), std::size_t{0});
  nearest_px_.assign(n, std::numeric_limits<double>::infinity());
  std::vector<Link> links;
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = a + 1; b < n; ++b) {
      const double distance_px = (lights[lamps_[a]].centre_px - lights[lamps_[b]].centre_px).norm();
      nearest_px_[a] = std::min(nearest_px_[a], distance_px);
      nearest_px_[b] = std::min(nearest_px_[b], distance_px);
      double reach_px = 0.0;
      for (const std::size_t one : {lamps_[a], lamps_[b]})
        reach_px += LampFitter::reach_px(rim_of(peaks[one]), lights[one].spread_px.maxCoeff(),
                                         core_sigma_px_);
      if (distance_px < reach_px) links.push_back({distance_px / reach_px, a, b});
    }
  std::sort(links.begin(), links.end(),
            [](const Link& one, const Link& other) { return one.share < other.share; });
  for (const Link& link : links) {
    const std::size_t kept = group_of_[link.a], joined = group_of_[link.b];
    if (kept == joined) continue;
    const auto size = std::count_if(group_of_.begin(), group_of_.end(), [&](std::size_t group) {
      return group == kept || group == joined;
    });
    if (static_cast<std::size_t>(size) > LampFitter::kMostLamps) continue;
    std::replace(group_of_.begin(), group_of_.end(), joined, kept);
  }
}

LampGuess LampMeter::guess_of(const Peak& peak, const Measured& light, double nearest_px,
                              double since_s) {
  LampGuess guess;
  looks_.push_back(0);
  guess.centre_px = light.centre_px;
  guess.rim_px = rim_of(peak);
  guess.size_px = light.spread_px.maxCoeff();
  double least_px = std::min(kSameShare * nearest_px, kMostMove_px);
  for (const Known& known : before_) {
    const Eigen::Vector2d moved_px = light.centre_px - known.centre_px;
    if (!(moved_px.norm() < least_px)) continue;
    least_px = moved_px.norm();
    looks_.back() = (known.looks + 1) % kLooks;
    guess.radius_px.reset();
    if (looks_.back() > 0) guess.radius_px = known.radius_px;
    if (exposure_s_ && since_s > 0.0) guess.motion_px = moved_px * (*exposure_s_ / since_s);
  }
  return guess;
}

void LampMeter::measure(const FrameLight& light, CameraTime time, const std::vector<Peak>& peaks,
                        std::vector<Measured>& lights) {
  lamps_.clear();
  for (std::size_t i = 0; i < peaks.size(); ++i)
    if (lights[i].lamp_like && !lights[i].cut_by_edge && rim_of(peaks[i]) < kMostRim_px)
      lamps_.push_back(i);
  find_groups(peaks, lights);
  const double since_s =
      before_at_ ? std::chrono::duration<double>(time - *before_at_).count() : 0.0;
  now_.clear();
  std::vector<std::size_t> members;
  for (std::size_t group = 0; group < lamps_.size(); ++group) {
    members.clear();
    guesses_.clear();
    looks_.clear();
    for (std::size_t k = 0; k < lamps_.size(); ++k) {
      if (group_of_[k] != group) continue;
      members.push_back(lamps_[k]);
      guesses_.push_back(guess_of(peaks[lamps_[k]], lights[lamps_[k]], nearest_px_[k], since_s));
    }
    if (members.empty()) continue;
    const LampsFit& fit = fitter_.fit(light, guesses_, false);
    for (std::size_t k = 0; k < members.size(); ++k) {
      Measured& seen = lights[members[k]];
      const double last_px = guesses_[k].radius_px.value_or(0.6 * guesses_[k].rim_px);
      const bool found = !fit.lamps.empty() && near(fit.lamps[k], seen);
      now_.push_back({seen.centre_px, found ? fit.lamps[k].radius_px : last_px, looks_[k]});
      seen.bad_fit = !found || fit.bad_fit;
      if (!found) continue;
      const LampFit& lamp = fit.lamps[k];
      now_.back().centre_px = lamp.centre_px;
      if (lamp.flux_sigma < kLeastKnown * lamp.flux)
        seen.lamp = LampLight{lamp.flux, lamp.flux_sigma, lamp.radius_px, lamp.radius_sigma_px};
      if (fit.bad_fit) continue;
      seen.centre_px = lamp.centre_px;
      seen.centre_sigma_px = lamp.centre_sigma_px;
    }
  }
  std::swap(before_, now_);
  before_at_ = time;
}

}  // namespace vildar
