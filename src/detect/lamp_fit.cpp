#include "detect/lamp_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "core/quantity.h"
#include "detect/censored.h"
#include "detect/pixel_sums.h"
#include "detect/residual_shape.h"

namespace vildar {
namespace {

constexpr double kLeastRadius_px = 0.1;  // a point, to any PSF of half a pixel and more
constexpr double kPatch_px2 = 16.0;      // area that is uneven together
constexpr double kStill_px = 0.3;        // a way this short widens a core of 0.5 px by 1.5 %
constexpr double kSmearPiece_px = 1.5;
constexpr int kMostIterations = 20;
// Expected fall of the cost: a sixteenth of a sigma, and one small enough for the next step to be
// the last, which nobody needs to look at: what it leaves is a tenth of it.
constexpr double kDone = 4e-3, kLastStep = 0.04;
constexpr double kRounding = 1e-6, kLeastFall = 1e-3;  // of costs in single precision

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

void LampFitter::Rows::resize(std::size_t lamp_count, std::size_t samples) {
  lamps.resize(lamp_count);
  for (DiscImage::Pixels& lamp : lamps) lamp.clear(samples);
  backdrop.assign(samples, 0.0F);
  for (std::vector<float>* one : {&expected, &residual, &weight, &pull, &noise_share})
    one->resize(samples);
}

void LampFitter::gather(const FrameLight& light, std::span<const LampGuess> guesses,
                        std::span<const OtherLamp> others) {
  reach_px_.clear();
  middle_px_ = Eigen::Vector2d::Zero();
  for (const LampGuess& guess : guesses) {
    reach_px_.push_back(reach_px(guess.rim_px, guess.size_px, image_.shape().core_sigma_px) +
                        0.5 * guess.motion_px.norm());
    middle_px_ += guess.centre_px / static_cast<double>(guesses.size());
  }
  samples_.gather(light, guesses, reach_px_, others);
  for (const OtherLamp& other : others) {
    image_.set_radius(other.radius_px);
    image_.add_to(samples_.others, samples_.u_px, samples_.v_px,
                  other.centre_px - samples_.origin_px, other.flux);
  }
  terms_.clear();
  for (Rows* rows : {&accepted_, &trial_}) rows->resize(guesses.size(), samples_.size());
}

// As many of the background's terms as the attempt has.
void LampFitter::add_terms() {
  const Eigen::Vector2d middle_px = middle_px_ - samples_.origin_px;
  for (auto i = terms_.size(); i < static_cast<std::size_t>(attempt_.background_terms); ++i) {
    terms_.emplace_back(samples_.size(), 1.0F);
    for (std::size_t k = 0; k < samples_.size() && i > 0; ++k) {
      const double x = (static_cast<double>(samples_.u_px[k]) - middle_px.x()) / reach_px_.front();
      const double y = (static_cast<double>(samples_.v_px[k]) - middle_px.y()) / reach_px_.front();
      const double terms[] = {1.0, x, y, x * x - y * y, 2.0 * x * y, x * x + y * y};
      terms_[i][k] = static_cast<float>(terms[i]);
    }
  }
}

void LampFitter::set_parameters(const Vector& parameters) {
  parameters_ = parameters;
  if (per_lamp_ < 4) return;
  for (std::size_t i = 0; i < images_.size(); ++i)
    images_[i].set_radius(std::sqrt(parameters_[base(i) + 3]));
}

void LampFitter::list_rows(const Rows& rows) {
  rows_.clear();
  scale_ = Vector::Ones(size());
  for (std::size_t i = 0; i < images_.size(); ++i) {
    const DiscImage::Pixels& lamp = rows.lamps[i];
    const double flux = std::exp(parameters_[base(i)]);
    scale_.segment(base(i), per_lamp_).setConstant(flux);
    for (const std::vector<float>* row : {&lamp.share, &lamp.per_u, &lamp.per_v})
      rows_.emplace_back(*row);
    if (per_lamp_ < 4) continue;
    rows_.emplace_back(lamp.per_radius);
    scale_[base(i) + 3] = flux / (2.0 * images_[i].radius_px());
  }
  for (Eigen::Index i = 0; i < attempt_.background_terms; ++i)
    rows_.emplace_back(terms_[static_cast<std::size_t>(i)]);
}

LampFitter::Matrix LampFitter::squares(std::span<const float> weight) {
  sums_.resize(rows_.size() * (rows_.size() + 1) / 2);
  sum_squares(rows_, weight, sums_);
  Matrix all(size(), size());
  std::size_t k = 0;
  for (Eigen::Index i = 0; i < size(); ++i)
    for (Eigen::Index j = 0; j <= i; ++j)
      all(i, j) = all(j, i) = scale_[i] * scale_[j] * sums_[k++];
  return all;
}

LampFitter::Vector LampFitter::products(std::span<const float> factor) {
  Vector all(size());
  sum_products(rows_, factor, {all.data(), rows_.size()});
  return all.cwiseProduct(scale_);
}

void LampFitter::weigh_clipped(const FrameLight& light, Sum& sum) {
  const double variance = light.noise.variance(light.clip_light), sigma = std::sqrt(variance);
  for (std::size_t k = samples_.clear; k < samples_.size(); ++k) {
    trial_.weight[k] = trial_.pull[k] = 0.0F;
    if (samples_.keep[k] == 0.0F) continue;
    const Censored censored((static_cast<double>(trial_.expected[k]) - light.clip_light) / sigma);
    sum.cost += censored.cost;
    sum.frozen_cost += censored.cost;
    trial_.weight[k] = static_cast<float>(censored.curve / variance);
    trial_.pull[k] = static_cast<float>(censored.slope / sigma);
  }
}

// Scores with the variance of the model rather than of the pixel: the likelihood's own for counts,
// and without the bias of weights that know the noise.
LampFitter::Sum LampFitter::add_up(const FrameLight& light) {
  const std::size_t clear = samples_.clear;
  trial_.resize(images_.size(), samples_.size());
  for (std::size_t i = 0; i < images_.size(); ++i)
    for (const Smear& smear : smears_[i])
      images_[i].add_to(trial_.lamps[i], samples_.u_px, samples_.v_px,
                        parameters_.segment<2>(base(i) + 1) + smear.offset_px - samples_.origin_px,
                        smear.weight);
  list_rows(trial_);
  const auto terms = static_cast<std::size_t>(attempt_.background_terms);
  factor_.clear();
  for (Eigen::Index i = base(images_.size()); i < size(); ++i)
    factor_.push_back(static_cast<float>(parameters_[i]));
  add_rows(std::span(rows_).last(terms), factor_, trial_.backdrop);
  trial_.expected = samples_.others;
  std::vector<PixelRow> shares{trial_.backdrop};
  factor_.assign(1, 1.0F);
  for (std::size_t i = 0; i < images_.size(); ++i) {
    shares.emplace_back(trial_.lamps[i].share);
    factor_.push_back(static_cast<float>(scale_[base(i)]));
  }
  add_rows(shares, factor_, trial_.expected);

  const auto row = [&](const std::vector<float>& all) { return PixelRow(all).first(clear); };
  const auto out = [&](std::vector<float>& all) { return std::span(all).first(clear); };
  const WeighedCosts costs =
      weigh({row(samples_.light), row(samples_.keep), row(trial_.expected), row(trial_.backdrop),
             row(accepted_.weight), out(trial_.residual), out(trial_.weight), out(trial_.pull),
             out(trial_.noise_share)},
            light.noise, kPatch_px2 * attempt_.uneven * attempt_.uneven);
  Sum sum;
  sum.cost = costs.own;
  sum.frozen_cost = costs.frozen;
  weigh_clipped(light, sum);
  sum.information = squares(trial_.weight);
  sum.score = products(trial_.pull);
  return sum;
}

// Where pixels clip, the rim fixes the flux for each radius, a share of the rim's.
void LampFitter::start(const FrameLight& light, std::span<const LampGuess> guesses,
                       double rim_share, bool radius_known) {
  const double core_px = image_.shape().core_sigma_px;
  lights_.clear();
  for (std::size_t k = 0; k < samples_.size(); ++k)
    if (samples_.keep[k] > 0.0F) lights_.push_back(samples_.light[k] - samples_.others[k]);
  double sum = 0.0, most = 0.0;
  for (const float here : lights_) {
    sum += static_cast<double>(here);
    most = std::max(most, static_cast<double>(here));
  }
  const auto middle = lights_.begin() + static_cast<std::ptrdiff_t>(lights_.size() / 2);
  std::nth_element(lights_.begin(), middle, lights_.end());
  const double background = std::min(static_cast<double>(*middle), 0.5 * light.clip_light);
  sum -= background * static_cast<double>(lights_.size());
  most -= background;
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
  for (int i = 0; i < kMostIterations; ++i, ++result_.iterations) {
    Vector move = step(sum, damping);
    if (!move.allFinite()) return false;
    const double fall = move.dot(sum.score);
    if (damping < 1.0 && fall < kDone) return true;
    const std::optional<Vector> after = moved(move, guesses);
    if (!after) return false;
    const Vector before = parameters_;
    set_parameters(*after);
    if (damping < 1.0 && fall < kLastStep) return true;
    Sum trial = add_up(light);
    if (trial.frozen_cost <= (1.0 + kRounding) * sum.cost + kLeastFall) {
      sum = std::move(trial);
      std::swap(accepted_, trial_);
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

void LampFitter::judge(std::span<const LampGuess> guesses) {
  ResidualShape shape(guesses.size());
  for (std::size_t k = 0; k < samples_.clear; ++k) {
    if (samples_.keep[k] == 0.0F) continue;
    const Eigen::Vector2d at_px =
        samples_.origin_px + Eigen::Vector2f(samples_.u_px[k], samples_.v_px[k]).cast<double>();
    std::size_t nearest = 0;
    double least = 1e9;
    Eigen::Vector2d offset_px;
    for (std::size_t i = 0; i < guesses.size(); ++i) {
      const Eigen::Vector2d from_px = at_px - parameters_.segment<2>(base(i) + 1);
      const double inner_px = std::max(guesses[i].rim_px - 1.0, 0.0);
      const double ring =
          std::max(from_px.norm() - inner_px, 0.0) / (attempt_.reach * reach_px_[i] - inner_px);
      if (ring > least) continue;
      nearest = i;
      least = ring;
      offset_px = from_px;
    }
    const auto residual = static_cast<double>(accepted_.residual[k]);
    shape.add(nearest, offset_px, least,
              residual * std::sqrt(static_cast<double>(accepted_.weight[k])),
              static_cast<double>(accepted_.noise_share[k]));
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
LampFitter::Matrix LampFitter::covariance(const Matrix& inverse) {
  factor_ = accepted_.weight;
  for (std::size_t k = 0; k < samples_.clear; ++k)
    factor_[k] = accepted_.pull[k] * accepted_.pull[k];
  const Matrix spread = squares(factor_);
  return (inverse * result_.variance_factor).cwiseMax(inverse * spread * inverse);
}

LampFitter::Vector LampFitter::by_wing_share() {
  factor_ = accepted_.weight;
  for (std::size_t k = 0; k < samples_.size(); ++k) {
    double light = 0.0;
    for (std::size_t i = 0; i < images_.size(); ++i)
      light += scale_[base(i)] * static_cast<double>(accepted_.lamps[i].per_wing_share[k]);
    factor_[k] *= static_cast<float>(light);
  }
  return products(factor_);
}

// Gauss and Legendre, two points to each piece of a lamp's way.
void LampFitter::smear(std::span<const LampGuess> guesses) {
  smears_.assign(guesses.size(), {});
  for (std::size_t i = 0; i < guesses.size(); ++i) {
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
  smear(guesses);
  gather(light, guesses, others);
  Sum sum;
  bool found = false;
  for (int k = first_attempt; k < static_cast<int>(kAttempts.size()); ++k) {
    attempt_ = kAttempts[static_cast<std::size_t>(k)];
    result_.attempt = k;
    samples_.keep_within(attempt_.reach);
    add_terms();
    found = fit_background(light, guesses, radius_known, found, sum);
    // Where the plainest backgrounds lead nowhere, a freer one takes the lamp's light for its own.
    if (!found && k >= kNothingRound) break;
    if (found && (lamp_is_other_ || (!result_.bad_fit && k != kNothingRound))) break;
  }
  if (!found) return result_;

  const Eigen::LDLT<Matrix> information(sum.information);
  if (information.info() != Eigen::Success || !information.isPositive()) return result_;
  const Matrix inverse = information.solve(Matrix::Identity(size(), size()));
  list_rows(accepted_);
  const Matrix found_covariance = covariance(inverse);
  const Vector by_wings = information.solve(by_wing_share()) * wing_share_sigma_;
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
