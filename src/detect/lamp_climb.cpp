// How LampFitter finds the summit of the likelihood.
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "detect/lamp_fit.h"

namespace vildar {
namespace {

constexpr double kLeastRadius_px = 0.1;  // a point, to any PSF of half a pixel and more
constexpr std::size_t kBackgroundPixels = 256;
constexpr int kMostIterations = 20;
// Expected fall of the cost, in units of what errors in common make of it: a sixteenth of a sigma,
// and one small enough for the next step to be the last, which nobody needs to look at: what it
// leaves is a tenth of it. So is one that leaves less than the former, as the step before did, but
// only where the residuals, which are judged as they were before it, are as good as those after it.
constexpr double kDone = 4e-3, kLastStep = 0.04, kMostUnseen = 1.0;
constexpr double kRounding = 1e-6, kLeastFall = 1e-3;  // of costs in single precision

/// The falls that a climb expected, of steps that were taken one after the other.
class Falls {
 public:
  void add(double fall) {
    std::rotate(last_.begin(), last_.begin() + 1, last_.end());
    last_.back() = fall;
  }
  void clear() { last_.fill(0.0); }
  /// What the step last added leaves, where each leaves the share of it that the one before left.
  double left() const {
    return last_[2] > 0.0 ? last_[3] * last_[3] / last_[2]
                          : std::numeric_limits<double>::infinity();
  }
  /// Whether the climb goes to and fro between two places, as across a step in the pixels' noise:
  /// it would do so for good.
  bool circle() const {
    constexpr double kAlike = 0.005;
    return std::abs(last_[3] - last_[1]) <= kAlike * last_[1] &&
           std::abs(last_[2] - last_[0]) <= kAlike * last_[0];
  }

 private:
  std::array<double, 4> last_{};
};

}  // namespace

/// Median of every so many pixels.
double LampFitter::middle_light() {
  const std::size_t step = samples_.size() / kBackgroundPixels + 1;
  lights_.clear();
  for (std::size_t k = 0; k < samples_.size(); k += step)
    if (samples_.keep[k] != 0.0F) lights_.push_back(samples_.light[k] - samples_.others[k]);
  const auto middle = lights_.begin() + static_cast<std::ptrdiff_t>(lights_.size() / 2);
  std::nth_element(lights_.begin(), middle, lights_.end());
  return static_cast<double>(*middle);
}

// Where pixels clip, the rim fixes the flux for each radius, a share of the rim's.
void LampFitter::start(const FrameLight& light, std::span<const LampGuess> guesses,
                       double rim_share, bool radius_known) {
  const double core_px = image_.shape().core_sigma_px;
  const double background =
      std::min(guesses.front().background ? *guesses.front().background : middle_light(),
               0.5 * light.clip_light);
  const auto seen_flux = [&] {
    double sum = 0.0, most = 0.0;
    for (std::size_t k = 0; k < samples_.size(); ++k) {
      if (samples_.keep[k] == 0.0F) continue;
      const auto here = static_cast<double>(samples_.light[k] - samples_.others[k]);
      sum += here;
      most = std::max(most, here);
    }
    sum -= background * static_cast<double>(samples_.used);
    return std::max(sum, 3.0 * (most - background)) / static_cast<double>(guesses.size());
  };
  Vector first = Vector::Zero(size());
  first[base(guesses.size())] = background;
  for (std::size_t i = 0; i < guesses.size(); ++i) {
    const LampGuess& guess = guesses[i];
    double radius_px =
        guess.rim_px > 0.0
            ? rim_share * guess.rim_px
            : 2.0 * std::sqrt(std::max(guess.size_px * guess.size_px - core_px * core_px, 0.0));
    radius_px = guess.radius_px.value_or(radius_px);
    if (!radius_known)
      radius_px = std::clamp(radius_px, kLeastRadius_px, DiscImage::kMostRadius_px);
    images_[i].set_radius(radius_px);
    const double flux = guess.flux ? *guess.flux
                        : guess.rim_px > 0.0
                            ? light.clip_light / images_[i].at(guess.rim_px, 0.0).share
                            : seen_flux();
    const Eigen::Index at = base(i);
    first[at] = std::log(std::max(flux, 1e-6));
    first[at + 1] = guess.centre_px.x();
    first[at + 2] = guess.centre_px.y();
    if (per_lamp_ == 4) first[at + 3] = radius_px * radius_px;
  }
  set_parameters(first);
}

LampFitter::Vector LampFitter::step(const Sum& sum, double damping) const {
  Matrix damped = sum.information;
  damped.diagonal() *= 1.0 + damping;
  damped.diagonal().array() += 1e-12 * damped.diagonal().maxCoeff();
  Vector move = damped.ldlt().solve(sum.score);
  if (per_lamp_ < 4) return move;
  // A disc that would shrink below a point stays one.
  constexpr double kLeast_px2 = kLeastRadius_px * kLeastRadius_px;
  bool held = false;
  Vector score = sum.score;
  for (std::size_t i = 0; i < images_.size(); ++i) {
    const Eigen::Index at = base(i) + 3;
    if (parameters_[at] > kLeast_px2 || !(move[at] < 0.0)) continue;
    damped.row(at).setZero();
    damped.col(at).setZero();
    damped(at, at) = 1.0;
    score[at] = 0.0;
    held = true;
  }
  if (held) move = damped.ldlt().solve(score);
  return move;
}

// None where a lamp would leave its pixels.
std::optional<LampFitter::Vector> LampFitter::moved(const Vector& move,
                                                    std::span<const LampGuess> guesses) const {
  Vector after = parameters_ + move;
  for (std::size_t lamp = 0; lamp < guesses.size(); ++lamp) {
    const Eigen::Index at = base(lamp);
    const double most_px = std::max(1.0, 0.5 * guesses[lamp].size_px);
    after[at] = parameters_[at] + std::clamp(move[at], -1.5, 1.5);
    for (Eigen::Index k = 1; k <= 2; ++k)
      after[at + k] = parameters_[at + k] + std::clamp(move[at + k], -most_px, most_px);
    if (per_lamp_ < 4) continue;
    const double before = parameters_[at + 3];
    const double low = std::max(0.2 * before, kLeastRadius_px * kLeastRadius_px);
    const double high =
        std::min(4.0 * before + 0.5, DiscImage::kMostRadius_px * DiscImage::kMostRadius_px);
    after[at + 3] = std::clamp(after[at + 3], low, high);
    if ((after.segment<2>(at + 1) - guesses[lamp].centre_px).norm() > reach_px_[lamp])
      return std::nullopt;
  }
  return after;
}

// Levenberg and Marquardt; true where it came to rest.
bool LampFitter::climb(const FrameLight& light, std::span<const LampGuess> guesses, Sum& sum) {
  sum = add_up(light);
  std::swap(accepted_, trial_);
  double damping = 1e-3;
  const double done = kDone * coding_.summed_px, last_step = kLastStep * coding_.summed_px,
               most_unseen = kMostUnseen * coding_.summed_px;
  Falls falls;
  for (int i = 0; i < kMostIterations; ++i, ++result_.iterations) {
    Vector move = step(sum, damping);
    if (!move.allFinite()) return false;
    const double fall = move.dot(sum.score);
    if (damping < 1.0 && fall < done) return true;
    falls.add(fall);
    if (falls.circle()) return false;
    const std::optional<Vector> after = moved(move, guesses);
    if (!after) return false;
    const Vector before = parameters_;
    set_parameters(*after);
    const bool settled = fall < most_unseen && falls.left() < done;
    if (damping < 1.0 && (fall < last_step || settled)) return true;
    Sum trial = add_up(light);
    if (trial.frozen_cost <= (1.0 + kRounding) * sum.cost + kLeastFall) {
      sum = std::move(trial);
      std::swap(accepted_, trial_);
      damping = std::max(0.2 * damping, 1e-7);
    } else {
      set_parameters(before);
      falls.clear();
      damping = std::max(10.0 * damping, 1e-4);
      if (damping > 1e8) return false;
    }
  }
  return false;
}

// A clipped lamp may be a large one or a bright one, and each has its own summit.
bool LampFitter::climb_from_best(const FrameLight& light, std::span<const LampGuess> guesses,
                                 bool several, bool radius_known, Sum& best) {
  static constexpr std::array<double, 4> kShares{0.85, 0.4, 0.6, 0.15};
  bool found = false, last_is_best = false;
  double least = 0.0;
  Vector best_parameters;
  LampsFit best_result;
  for (const double share : std::span(kShares).first(several ? kShares.size() : 1)) {
    start(light, guesses, share, radius_known);
    Sum sum;
    last_is_best = false;
    if (!climb(light, guesses, sum)) continue;
    judge(guesses);
    double cost = sum.cost;
    for (std::size_t k = 0; k < samples_.clear && several; ++k)
      if (accepted_.weight[k] > 0.0F) cost -= static_cast<double>(std::log(accepted_.weight[k]));
    if (found && cost >= least) continue;
    found = last_is_best = true;
    least = cost;
    best = std::move(sum);
    best_parameters = parameters_;
    best_result = result_;
    if (!result_.bad_fit) break;
  }
  if (!found || last_is_best) return found;
  set_parameters(best_parameters);
  add_up(light);
  std::swap(accepted_, trial_);
  result_ = best_result;
  return true;
}

bool LampFitter::fit_background(const FrameLight& light, std::span<const LampGuess> guesses,
                                bool radius_known, bool go_on, Sum& sum) {
  const Eigen::Index before = size();
  parameters_.conservativeResize(base(guesses.size()) + attempt_.background_terms);
  if (samples_.used < 2 * static_cast<std::size_t>(size())) return false;
  const bool clips = std::any_of(guesses.begin(), guesses.end(),
                                 [](const LampGuess& guess) { return guess.rim_px > 0.0; });
  const bool told = std::all_of(guesses.begin(), guesses.end(),
                                [](const LampGuess& guess) { return guess.radius_px.has_value(); });
  if (go_on) {
    parameters_.tail(size() - before).setZero();
    if (climb(light, guesses, sum)) {
      judge(guesses);
      return true;
    }
  }
  if (climb_from_best(light, guesses, clips && !told, radius_known, sum)) return true;
  if (!told || radius_known) return false;
  std::vector<LampGuess> anew(guesses.begin(), guesses.end());
  for (LampGuess& guess : anew) guess.radius_px = guess.flux = std::nullopt;
  return climb_from_best(light, anew, clips, radius_known, sum);
}

}  // namespace vildar
