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
/// A lamp starts from the radius of the last frame, and every so many frames from anew; from the
/// plainest background more often.
constexpr int kLooks = 64, kPlainLooks = 16;
constexpr double kFirstRadius = 0.6;  // of a disc that is not known, of its rim
constexpr double kOthersReach = 3.0;  // further off a lamp's wings are as good as level
constexpr double kSettled = 0.05;     // of ln flux
constexpr int kMostSweeps = 3;

bool near(const LampFit& lamp, const Measured& seen) {
  return (lamp.centre_px - seen.centre_px).norm() <=
         kMostShift_px + kMostShiftShare * seen.spread_px.maxCoeff();
}

}  // namespace

double rim_px(const Peak& peak) {
  return peak.clipped_px > 0 ? std::sqrt(peak.clipped_px / kPi) + peak.eroded_px : 0.0;
}

LampMeter::LampMeter(const PsfSite& psf, std::optional<double> exposure_s)
    : fitter_(psf.shape, psf.wing_share_std),
      core_sigma_px_(psf.shape.core_sigma_px),
      exposure_s_(exposure_s) {}

// Joins lamps whose cores meet, the nearest first, as far as they can be fitted together.
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
        reach_px += LampFitter::core_px(rim_px(peaks[one]), lights[one].spread_px.maxCoeff(),
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

// From the same lamp in the last frame, or from its rim.
void LampMeter::start(const FrameLight& light, std::size_t k, const Peak& peak,
                      const Measured& seen, double since_s) {
  LampGuess& guess = starts_[k];
  Known& now = now_[k];
  guess.centre_px = seen.centre_px;
  guess.rim_px = rim_px(peak);
  guess.size_px = seen.spread_px.maxCoeff();
  now.lamp.centre_px = seen.centre_px;
  now.lamp.core_px = LampFitter::core_px(guess.rim_px, guess.size_px, core_sigma_px_);
  double least_px = std::min(kSameShare * nearest_px_[k], kMostMove_px);
  const Known* same = nullptr;
  for (const Known& known : before_) {
    const double moved_px = (seen.centre_px - known.lamp.centre_px).norm();
    if (!(moved_px < least_px)) continue;
    least_px = moved_px;
    same = &known;
  }
  if (same != nullptr) {
    now.looks = (same->looks + 1) % kLooks;
    if (exposure_s_ && since_s > 0.0)
      guess.motion_px = (seen.centre_px - same->lamp.centre_px) * (*exposure_s_ / since_s);
  }
  if (same != nullptr && same->fitted) {
    now.fitted = true;
    now.lamp.radius_px = same->lamp.radius_px;
    now.lamp.flux = same->lamp.flux;
    guess.background = same->background;
    if (now.looks % kPlainLooks > 0) now.first_attempt = std::max(0, same->attempt - 1);
    if (now.looks > 0) {
      guess.radius_px = same->lamp.radius_px;
      guess.flux = same->lamp.flux;
    }
    return;
  }
  now.lamp.radius_px = kFirstRadius * guess.rim_px;
  now.lamp.flux = guess.rim_px > 0.0
                      ? fitter_.rim_flux(guess.rim_px, now.lamp.radius_px, light.clip_light)
                      : seen.flux;
}

/// False where a neighbour's light turned out to be other than it was taken for. A group that was
/// fitted before in this frame waits until that happens to a light that reaches it.
bool LampMeter::fit_group(const FrameLight& light, const FrameLight* coded, std::size_t group,
                          std::vector<Measured>& lights) {
  members_.clear();
  guesses_.clear();
  others_.clear();
  int first_attempt = 0;
  for (std::size_t k = 0; k < lamps_.size(); ++k) {
    if (group_of_[k] != group) continue;
    members_.push_back(k);
    guesses_.push_back(starts_[k]);
    first_attempt = std::max(first_attempt, now_[k].first_attempt);
  }
  const auto reaches = [&](const OtherLamp& other) {
    return std::any_of(guesses_.begin(), guesses_.end(), [&](const LampGuess& guess) {
      return (guess.centre_px - other.centre_px).norm() <
             kOthersReach * LampFitter::reach_px(guess.rim_px, guess.size_px, core_sigma_px_);
    });
  };
  bool others_changed = false;
  for (std::size_t k = 0; k < lamps_.size(); ++k) {
    if (group_of_[k] == group || !reaches(now_[k].lamp)) continue;
    others_.push_back(now_[k].lamp);
    others_changed |= changed_by_[k] > fitted_by_[group];
  }
  if (fitted_by_[group] > 0 && !others_changed) return true;
  fitted_by_[group] = ++fits_;
  const LampsFit fit = fitter_.fit(light, guesses_, false, others_, first_attempt);
  const LampsFit* told = &fit;
  const auto clips = [](const LampGuess& guess) { return guess.rim_px > 0.0; };
  if (coded != nullptr && !fit.lamps.empty() && !fit.bad_fit &&
      std::any_of(guesses_.begin(), guesses_.end(), clips)) {
    for (std::size_t i = 0; i < guesses_.size(); ++i) {
      guesses_[i].centre_px = fit.lamps[i].centre_px;
      guesses_[i].radius_px = fit.lamps[i].radius_px;
      guesses_[i].flux = fit.lamps[i].flux;
      guesses_[i].background = fit.background;
    }
    told = &fitter_.fit(*coded, guesses_, false, others_, fit.attempt);
  }
  bool settled = true;
  for (std::size_t i = 0; i < members_.size(); ++i) {
    Known& now = now_[members_[i]];
    Measured& seen = lights[lamps_[members_[i]]];
    seen.lamp.reset();
    const bool found = !fit.lamps.empty() && near(fit.lamps[i], seen);
    seen.bad_fit = !found || fit.bad_fit;
    if (!found) {
      now.fitted = false;
      continue;
    }
    const LampFit& lamp = fit.lamps[i];
    if (!(std::abs(std::log(lamp.flux / now.lamp.flux)) < kSettled)) {
      changed_by_[members_[i]] = fits_;
      settled &= now.fitted;
    }
    now.fitted = true;
    now.attempt = fit.attempt;
    now.lamp.centre_px = lamp.centre_px;
    now.lamp.radius_px = lamp.radius_px;
    now.lamp.flux = lamp.flux;
    now.background = fit.background;
    starts_[members_[i]].radius_px = lamp.radius_px;
    starts_[members_[i]].flux = lamp.flux;
    starts_[members_[i]].background = fit.background;
    if (fit.bad_fit) continue;
    seen.centre_px = lamp.centre_px;
    seen.centre_sigma_px = lamp.centre_sigma_px;
    if (told->lamps.empty() || told->bad_fit) continue;
    const LampFit& shining = told->lamps[i];
    const LampLight measured{shining.flux,
                             shining.flux_sigma,
                             shining.radius_px,
                             shining.radius_sigma_px,
                             shining.log_flux_per_radius,
                             shining.log_flux_sigma_at_radius,
                             light.coding.has_value()};
    LampLight at_radius = measured;
    at_radius.flux_sigma = shining.flux * shining.log_flux_sigma_at_radius;
    // Other pictures may tell its radius.
    if (measured.told() || (measured.coded && at_radius.told())) seen.lamp = measured;
  }
  return settled;
}

void LampMeter::measure(const FrameLight& light, const FrameLight* coded, CameraTime time,
                        const std::vector<Peak>& peaks, std::vector<Measured>& lights) {
  lamps_.clear();
  for (std::size_t i = 0; i < peaks.size(); ++i)
    if (lights[i].lamp_like && !lights[i].cut_by_edge && rim_px(peaks[i]) < kMostRim_px)
      lamps_.push_back(i);
  find_groups(peaks, lights);
  const double since_s =
      before_at_ ? std::chrono::duration<double>(time - *before_at_).count() : 0.0;
  now_.assign(lamps_.size(), {});
  starts_.assign(lamps_.size(), {});
  for (std::size_t k = 0; k < lamps_.size(); ++k)
    start(light, k, peaks[lamps_[k]], lights[lamps_[k]], since_s);
  fits_ = 0;
  fitted_by_.assign(lamps_.size(), 0);
  changed_by_.assign(lamps_.size(), 0);
  bool settled = true;
  for (int sweep = 0; sweep == 0 || (!settled && sweep < kMostSweeps); ++sweep) {
    settled = true;
    for (std::size_t group = 0; group < lamps_.size(); ++group)
      if (std::find(group_of_.begin(), group_of_.end(), group) != group_of_.end())
        settled = fit_group(light, coded, group, lights) && settled;
  }
  std::swap(before_, now_);
  before_at_ = time;
}

}  // namespace vildar
