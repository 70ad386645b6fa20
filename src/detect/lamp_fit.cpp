#include "detect/lamp_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "core/quantity.h"
#include "detect/censored.h"
#include "detect/residual_shape.h"

namespace vildar {
namespace {

constexpr double kLeastRadius_px = 0.1;  // a point, to any PSF of half a pixel and more
constexpr double kMostPixels = 600.0;    // of one lamp, beside those about its rim
constexpr double kMostRimPixels = 600.0;
constexpr double kDenseSizes = 3.0;  // of a lamp that does not clip, its size
constexpr double kRimInside_px = 5.0, kRimOutside_px = 3.0;
/// Compression digs holes into clipped areas: a pixel this far inside the rim that nearly clips
/// does clip.
constexpr double kHoleDepth_px = 1.5, kHoleLight = 0.8;
constexpr double kPatch_px2 = 16.0;  // area that is uneven together
constexpr double kStill_px = 0.3;    // a way this short widens a core of 0.5 px by 1.5 %
constexpr double kSmearPiece_px = 1.5;
constexpr int kMostIterations = 20;
constexpr double kDone = 4e-3;  // expected fall of the cost: a sixteenth of a sigma

}  // namespace

constexpr std::array<LampFitter::Attempt, 7> LampFitter::kAttempts{
    Attempt{1, 1.0, 0.0},  Attempt{5, 1.0, 0.0},  Attempt{6, 1.0, 0.0}, Attempt{6, 0.8, 0.0},
    Attempt{6, 0.65, 0.0}, Attempt{6, 0.65, 0.1}, Attempt{6, 0.65, 0.2}};

double PixelNoise::variance(double light) const {
  const double place = std::clamp(light, 0.0, 1.0) * static_cast<double>(rounding.size() - 1);
  return dark_variance + std::max(light, 0.0) / electrons +
         static_cast<double>(rounding[static_cast<std::size_t>(place + 0.5)]);
}

LampFitter::LampFitter(const PsfShape& psf, double wing_share_sigma)
    : wing_share_sigma_(wing_share_sigma), image_(psf) {}

double LampFitter::reach_px(double rim_px, double size_px, double core_sigma_px) {
  return rim_px > 0.0 ? 1.6 * rim_px + 4.0 * core_sigma_px + 6.0
                      : std::max(3.5 * size_px, 4.0 * core_sigma_px) + 3.0;
}

double LampFitter::core_px(double rim_px, double size_px, double core_sigma_px) {
  return rim_px > 0.0 ? rim_px + 3.0 * core_sigma_px : 3.0 * std::max(size_px, core_sigma_px);
}

double LampFitter::rim_flux(double rim_px, double radius_px, double clip_light) {
  image_.set_radius(radius_px);
  return clip_light / image_.at(rim_px, 0.0).share;
}

void LampFitter::gather(const FrameLight& light, std::span<const LampGuess> guesses,
                        std::span<const OtherLamp> others) {
  samples_.clear();
  reach_px_.clear();
  const LumaView& luma = light.luma;
  for (const LampGuess& guess : guesses)
    reach_px_.push_back(reach_px(guess.rim_px, guess.size_px, image_.shape().core_sigma_px) +
                        0.5 * guess.motion_px.norm());
  for (std::size_t i = 0; i < guesses.size(); ++i) {
    const double reach = reach_px_[i], rim = guesses[i].rim_px;
    const Eigen::Vector2d& centre = guesses[i].centre_px;
    // Where there are more pixels than a fit needs, every so many of them do.
    const auto stride_of = [](double area_px2, double most) {
      return std::max(1, static_cast<int>(std::ceil(area_px2 / most)));
    };
    const double dense = rim > 0.0 ? rim + kRimOutside_px : kDenseSizes * guesses[i].size_px;
    const int stride = stride_of(kPi * (reach * reach - dense * dense), kMostPixels);
    const int rim_stride =
        stride_of(2.0 * kPi * rim * (kRimInside_px + kRimOutside_px), kMostRimPixels);
    const auto first = [](double at) { return std::max(0, static_cast<int>(std::ceil(at))); };
    const auto last = [](double at, int size) {
      return std::min(size - 1, static_cast<int>(std::floor(at)));
    };
    for (int v = first(centre.y() - reach); v <= last(centre.y() + reach, luma.height_px); ++v)
      for (int u = first(centre.x() - reach); u <= last(centre.x() + reach, luma.width_px); ++u) {
        const Eigen::Vector2d at(u, v);
        const double distance = (at - centre).norm();
        if (distance > reach) continue;
        if ((u + 2 * v) % (distance > dense ? stride : rim_stride) != 0) continue;
        bool left_out = false, inside = false;
        for (std::size_t j = 0; j < guesses.size(); ++j) {
          const double from_px = (at - guesses[j].centre_px).norm();
          left_out |= j < i && from_px <= reach_px_[j];
          // Deep inside a clipped area every model agrees.
          left_out |= from_px < guesses[j].rim_px - kRimInside_px;
          inside |= from_px < guesses[j].rim_px - kHoleDepth_px;
        }
        for (const OtherLamp& other : others)
          left_out |= (at - other.centre_px).squaredNorm() < other.core_px * other.core_px;
        if (left_out) continue;
        const int code = luma.code(u, v);
        const double here = static_cast<double>(light.linear[static_cast<std::size_t>(code)]);
        const bool hole = inside && here > kHoleLight * light.clip_light;
        samples_.push_back({u, v, here, 0.0, distance / reach, hole || code >= light.clip_code});
      }
  }
  add_others(others);
}

void LampFitter::add_others(std::span<const OtherLamp> others) {
  for (const OtherLamp& other : others) {
    image_.set_radius(other.radius_px);
    for (Sample& sample : samples_)
      sample.others +=
          other.flux *
          image_.at(sample.u - other.centre_px.x(), sample.v - other.centre_px.y()).share;
  }
}

void LampFitter::set_parameters(const Vector& parameters) {
  parameters_ = parameters;
  if (per_lamp_ < 4) return;
  for (std::size_t i = 0; i < images_.size(); ++i)
    images_[i].set_radius(std::sqrt(parameters_[base(i) + 3]));
}

// One of the terms of a sum over lamps and, for a lamp that moves, over its path.
double LampFitter::model(const Sample& sample, Vector& gradient, double& by_wing_share,
                         double& backdrop) const {
  const Eigen::Index background = base(images_.size());
  gradient[background] = 1.0;
  if (attempt_.background_terms > 1) {
    const double x = (sample.u - middle_px_.x()) / reach_px_.front();
    const double y = (sample.v - middle_px_.y()) / reach_px_.front();
    gradient[background + 1] = x;
    gradient[background + 2] = y;
    if (attempt_.background_terms > 3) {
      gradient[background + 3] = x * x - y * y;
      gradient[background + 4] = 2.0 * x * y;
    }
    if (attempt_.background_terms > 5) gradient[background + 5] = x * x + y * y;
  }
  backdrop = 0.0;
  for (Eigen::Index i = background; i < size(); ++i) backdrop += gradient[i] * parameters_[i];
  double light = sample.others + backdrop;
  by_wing_share = 0.0;
  for (std::size_t i = 0; i < images_.size(); ++i) {
    const Eigen::Index at = base(i);
    const double flux = std::exp(parameters_[at]);
    const double du = sample.u - parameters_[at + 1], dv = sample.v - parameters_[at + 2];
    DiscImage::Pixel pixel;
    for (const Smear& smear : smears_[i]) {
      const DiscImage::Pixel part =
          images_[i].at(du - smear.offset_px.x(), dv - smear.offset_px.y());
      pixel.share += smear.weight * part.share;
      pixel.per_u += smear.weight * part.per_u;
      pixel.per_v += smear.weight * part.per_v;
      pixel.per_radius += smear.weight * part.per_radius;
      pixel.per_wing_share += smear.weight * part.per_wing_share;
    }
    light += flux * pixel.share;
    by_wing_share += flux * pixel.per_wing_share;
    gradient[at] = flux * pixel.share;
    gradient[at + 1] = flux * pixel.per_u;
    gradient[at + 2] = flux * pixel.per_v;
    if (per_lamp_ == 4) gradient[at + 3] = flux * pixel.per_radius / (2.0 * images_[i].radius_px());
  }
  return light;
}

// Scores with the variance of the model rather than of the pixel: the likelihood's own for counts,
// and without the bias of weights that know the noise.
LampFitter::Sum LampFitter::add_up(const FrameLight& light) {
  Sum sum;
  sum.information = Matrix::Zero(size(), size());
  sum.score = sum.by_wing_share = Vector::Zero(size());
  Vector gradient(size());
  const double clip_variance = light.noise.variance(light.clip_light);
  const double clip_sigma = std::sqrt(clip_variance);
  for (std::size_t k = 0; k < samples_.size(); ++k) {
    const Sample& sample = samples_[k];
    double by_wing_share, backdrop;
    const double expected = model(sample, gradient, by_wing_share, backdrop);
    State& trial = trial_states_[k];
    trial = {};
    double pull;
    if (sample.clipped) {
      const Censored censored((expected - light.clip_light) / clip_sigma);
      trial.variance = clip_variance;
      sum.cost += censored.cost;
      sum.frozen_cost += censored.cost;
      trial.weight = censored.curve / clip_variance;
      pull = censored.slope / clip_sigma;
      if (trial.weight == 0.0) continue;
    } else {
      const double noise = light.noise.variance(expected);
      const double uneven = attempt_.uneven * std::max(backdrop, 0.0);
      trial.residual = sample.light - expected;
      trial.variance = noise + kPatch_px2 * uneven * uneven;
      trial.noise_share = noise / trial.variance;
      trial.weight = 1.0 / trial.variance;
      const double square = trial.residual * trial.residual;
      sum.cost += square * trial.weight;
      if (states_[k].variance > 0.0) sum.frozen_cost += square / states_[k].variance;
      pull = trial.residual * trial.weight;
    }
    for (Eigen::Index i = 0; i < size(); ++i) {
      const double weighted = trial.weight * gradient[i];
      sum.score[i] += pull * gradient[i];
      sum.by_wing_share[i] += weighted * by_wing_share;
      for (Eigen::Index j = 0; j <= i; ++j) sum.information(i, j) += weighted * gradient[j];
    }
  }
  sum.information.triangularView<Eigen::StrictlyUpper>() = sum.information.transpose();
  return sum;
}

// Where pixels clip, the rim fixes the flux for each radius, a share of the rim's.
void LampFitter::start(const FrameLight& light, std::span<const LampGuess> guesses,
                       double rim_share, bool radius_known) {
  const double core_px = image_.shape().core_sigma_px;
  lights_.clear();
  for (const Sample& sample : samples_) lights_.push_back(sample.light - sample.others);
  const auto middle = lights_.begin() + static_cast<std::ptrdiff_t>(lights_.size() / 2);
  std::nth_element(lights_.begin(), middle, lights_.end());
  const double background = std::min(*middle, 0.5 * light.clip_light);
  double sum = 0.0, most = 0.0;
  for (const Sample& sample : samples_) {
    const double here = sample.light - sample.others - background;
    sum += here;
    most = std::max(most, here);
  }
  sum = std::max(sum, 3.0 * most);
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
    double flux = sum / static_cast<double>(guesses.size());
    if (guess.flux)
      flux = *guess.flux;
    else if (guess.rim_px > 0.0)
      flux = light.clip_light / images_[i].at(guess.rim_px, 0.0).share;
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

// Levenberg and Marquardt; true where it came to rest.
bool LampFitter::climb(const FrameLight& light, std::span<const LampGuess> guesses, Sum& sum) {
  sum = add_up(light);
  std::swap(states_, trial_states_);
  double damping = 1e-3;
  for (int i = 0; i < kMostIterations; ++i, ++result_.iterations) {
    Vector move = step(sum, damping);
    if (!move.allFinite()) return false;
    if (damping < 1.0 && move.dot(sum.score) < kDone) return true;
    const Vector before = parameters_;
    Vector after = before + move;
    for (std::size_t lamp = 0; lamp < guesses.size(); ++lamp) {
      const Eigen::Index at = base(lamp);
      const double most_px = std::max(1.0, 0.5 * guesses[lamp].size_px);
      after[at] = before[at] + std::clamp(move[at], -1.5, 1.5);
      for (Eigen::Index k = 1; k <= 2; ++k)
        after[at + k] = before[at + k] + std::clamp(move[at + k], -most_px, most_px);
      if (per_lamp_ < 4) continue;
      const double low = std::max(0.2 * before[at + 3], kLeastRadius_px * kLeastRadius_px);
      const double high = std::min(4.0 * before[at + 3] + 0.5,
                                   DiscImage::kMostRadius_px * DiscImage::kMostRadius_px);
      after[at + 3] = std::clamp(after[at + 3], low, high);
      if ((after.segment<2>(at + 1) - guesses[lamp].centre_px).norm() > reach_px_[lamp])
        return false;
    }
    set_parameters(after);
    Sum trial = add_up(light);
    if (trial.frozen_cost <= sum.cost + 1e-9) {
      sum = std::move(trial);
      std::swap(states_, trial_states_);
      damping = std::max(0.2 * damping, 1e-7);
    } else {
      set_parameters(before);
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
  bool found = false;
  double least = 0.0;
  Vector best_parameters;
  LampsFit best_result;
  for (const double share : std::span(kShares).first(several ? kShares.size() : 1)) {
    start(light, guesses, share, radius_known);
    Sum sum;
    if (!climb(light, guesses, sum)) continue;
    judge(guesses);
    double cost = sum.cost;
    for (const State& state : states_) cost += std::log(state.variance);
    if (found && cost >= least) continue;
    found = true;
    least = cost;
    best = std::move(sum);
    best_parameters = parameters_;
    best_result = result_;
    if (!result_.bad_fit) break;
  }
  if (!found) return false;
  set_parameters(best_parameters);
  result_ = best_result;
  return true;
}

bool LampFitter::fit_background(const FrameLight& light, std::span<const LampGuess> guesses,
                                bool radius_known, bool go_on, Sum& sum) {
  const Eigen::Index before = size();
  parameters_.conservativeResize(base(guesses.size()) + attempt_.background_terms);
  if (samples_.size() < 2 * static_cast<std::size_t>(size())) return false;
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

void LampFitter::judge(std::span<const LampGuess> guesses) {
  ResidualShape shape(guesses.size());
  for (std::size_t k = 0; k < samples_.size(); ++k) {
    const Sample& sample = samples_[k];
    const State& state = states_[k];
    if (sample.clipped) continue;
    std::size_t nearest = 0;
    double least = 1e9;
    Eigen::Vector2d offset_px;
    for (std::size_t i = 0; i < guesses.size(); ++i) {
      const Eigen::Vector2d from_px =
          Eigen::Vector2d(sample.u, sample.v) - parameters_.segment<2>(base(i) + 1);
      const double inner_px = std::max(guesses[i].rim_px - 1.0, 0.0);
      const double ring =
          std::max(from_px.norm() - inner_px, 0.0) / (attempt_.reach * reach_px_[i] - inner_px);
      if (ring > least) continue;
      nearest = i;
      least = ring;
      offset_px = from_px;
    }
    shape.add(nearest, offset_px, least, state.residual / std::sqrt(state.variance),
              state.noise_share);
  }
  const ResidualShape::Verdict verdict =
      shape.verdict(static_cast<double>(per_lamp_), static_cast<double>(attempt_.background_terms));
  result_.chi2_per_dof = verdict.chi2_per_dof;
  result_.bad_fit = verdict.shaped;
  lamp_is_other_ =
      verdict.shaped && verdict.round &&
      (result_.attempt == kNothingRound || (result_.attempt == 0 && !verdict.quarters_differ));
  result_.variance_factor = std::max(1.0, verdict.chi2_per_dof);
  if (result_.bad_fit)
    result_.variance_factor = std::max(result_.variance_factor, verdict.shape_per_dof);
}

// Of the information, and of what the residuals themselves say of their variance (Huber 1967): the
// larger on the diagonal. The camera's electrons are not known.
LampFitter::Matrix LampFitter::covariance(const Matrix& inverse) const {
  Matrix spread = Matrix::Zero(size(), size());
  Vector gradient(size());
  for (std::size_t k = 0; k < samples_.size(); ++k) {
    const State& state = states_[k];
    if (state.weight == 0.0) continue;
    double by_wing_share, backdrop;
    model(samples_[k], gradient, by_wing_share, backdrop);
    const double pull = state.weight * state.residual;
    spread.noalias() +=
        (samples_[k].clipped ? state.weight : pull * pull) * gradient * gradient.transpose();
  }
  return (inverse * result_.variance_factor).cwiseMax(inverse * spread * inverse);
}

const LampsFit& LampFitter::fit(const FrameLight& light, std::span<const LampGuess> guesses,
                                bool radius_known, std::span<const OtherLamp> others,
                                int first_attempt) {
  if (guesses.empty() || guesses.size() > kMostLamps)
    throw std::invalid_argument("LampFitter: fits 1 to 4 lamps together, not " +
                                std::to_string(guesses.size()));
  for (const LampGuess& guess : guesses)
    if (radius_known && !guess.radius_px)
      throw std::invalid_argument("LampFitter: a known radius is not given");
  result_ = {};
  per_lamp_ = radius_known ? 3 : 4;
  images_.assign(guesses.size(), image_);
  smears_.assign(guesses.size(), {});
  for (std::size_t i = 0; i < guesses.size(); ++i) {
    // Gauss and Legendre, two points to each piece.
    const Eigen::Vector2d& motion_px = guesses[i].motion_px;
    const double length_px = motion_px.norm();
    if (length_px < kStill_px) {
      smears_[i].push_back({Eigen::Vector2d::Zero(), 1.0});
      continue;
    }
    const int pieces = static_cast<int>(std::ceil(length_px / kSmearPiece_px));
    for (int piece = 0; piece < pieces; ++piece)
      for (const double node : {-0.28867513459481287, 0.28867513459481287}) {
        const double share = (piece + 0.5 + node) / pieces - 0.5;
        smears_[i].push_back({share * motion_px, 0.5 / pieces});
      }
  }
  gather(light, guesses, others);
  middle_px_ = Eigen::Vector2d::Zero();
  for (const LampGuess& guess : guesses)
    middle_px_ += guess.centre_px / static_cast<double>(guesses.size());
  Sum sum;
  bool found = false;
  for (int k = first_attempt; k < static_cast<int>(kAttempts.size()); ++k) {
    attempt_ = kAttempts[static_cast<std::size_t>(k)];
    result_.attempt = k;
    std::erase_if(samples_, [&](const Sample& one) { return one.place > attempt_.reach; });
    states_.assign(samples_.size(), {});
    trial_states_.resize(samples_.size());
    found = fit_background(light, guesses, radius_known, found, sum);
    // Where the plainest backgrounds lead nowhere, a freer one takes the lamp's light for its own.
    if (!found && k >= kNothingRound) break;
    if (found && (lamp_is_other_ || (!result_.bad_fit && k != kNothingRound))) break;
  }
  if (!found) return result_;

  const Eigen::LDLT<Matrix> information(sum.information);
  if (information.info() != Eigen::Success || !information.isPositive()) return result_;
  const Matrix inverse = information.solve(Matrix::Identity(size(), size()));
  const Matrix found_covariance = covariance(inverse);
  const Vector by_wings = information.solve(sum.by_wing_share) * wing_share_sigma_;
  const auto sigma = [&](Eigen::Index i) {
    return std::hypot(std::sqrt(std::max(found_covariance(i, i), 0.0)), by_wings[i]);
  };
  for (std::size_t i = 0; i < guesses.size(); ++i) {
    const Eigen::Index at = base(i);
    LampFit lamp;
    lamp.flux = std::exp(parameters_[at]);
    lamp.flux_sigma = lamp.flux * sigma(at);
    lamp.centre_px = parameters_.segment<2>(at + 1);
    lamp.centre_sigma_px = Eigen::Vector2d(sigma(at + 1), sigma(at + 2));
    lamp.radius_px = images_[i].radius_px();
    if (per_lamp_ == 4) lamp.radius_sigma_px = sigma(at + 3) / (2.0 * lamp.radius_px);
    result_.lamps.push_back(lamp);
  }
  result_.background = parameters_[base(guesses.size())];
  result_.background_sigma = sigma(base(guesses.size()));
  return result_;
}

}  // namespace vildar
