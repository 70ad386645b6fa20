#include "detect/lamp_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/quantity.h"
#include "detect/censored.h"
#include "detect/pixel_sums.h"
#include "detect/residual_shape.h"

namespace vildar {
namespace {

constexpr double kPatch_px2 = 16.0;  // area that is uneven together
constexpr double kStill_px = 0.3;    // a way this short widens a core of 0.5 px by 1.5 %
constexpr double kSmearPiece_px = 1.5;
constexpr double kBendHelps = 0.9;   // of what a level background leaves over
constexpr float kLeastAlone = 0.1F;  // of a pixel's residual, that its own pull leaves of it

// The first attempt at a background that is bent. Where it leaves something round, the lamps' own
// light is at fault.
constexpr int kBent = 1;

constexpr std::array<LampFitter::Attempt, 6> kAttempts{
    {{1, 1.0, 0.0}, {6, 1.0, 0.0}, {6, 0.8, 0.0}, {6, 0.65, 0.0}, {6, 0.65, 0.1}, {6, 0.65, 0.2}}};

// Coding with loss changes a lamp's rim all around, and a round term would take that: the first
// bend has none, and is there to be judged only.
constexpr Eigen::Index kNothingRound = 5;
constexpr std::array<LampFitter::Attempt, 7> kCodedAttempts{{{1, 1.0, 0.0},
                                                             {kNothingRound, 1.0, 0.0},
                                                             {6, 1.0, 0.0},
                                                             {6, 0.8, 0.0},
                                                             {6, 0.65, 0.0},
                                                             {6, 0.65, 0.1},
                                                             {6, 0.65, 0.2}}};

}  // namespace

std::span<const LampFitter::Attempt> LampFitter::attempts(const FrameLight& light) {
  if (light.coding) return kCodedAttempts;
  return kAttempts;
}

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
  for (std::vector<float>* one : {&expected, &backdrop, &residual, &weight, &pull, &noise_share})
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
  terms_set_ = 0;
  // Both, for a climb may be done where it starts.
  for (Rows* rows : {&accepted_, &trial_}) rows->resize(guesses.size(), samples_.size());
}

// As many of the background's terms as the attempt has.
void LampFitter::add_terms() {
  const auto wanted = static_cast<std::size_t>(attempt_.background_terms);
  if (terms_set_ >= wanted) return;
  terms_[0].assign(samples_.size(), 1.0F);
  terms_set_ = std::max<std::size_t>(terms_set_, 1);
  if (wanted == 1) return;
  const Eigen::Vector2f middle_px = (middle_px_ - samples_.origin_px).cast<float>();
  const auto place = [&](const std::vector<float>& at_px, float middle) -> Eigen::ArrayXf {
    const auto count = static_cast<Eigen::Index>(at_px.size());
    return (Eigen::Map<const Eigen::ArrayXf>(at_px.data(), count) - middle) /
           static_cast<float>(reach_px_.front());
  };
  const Eigen::ArrayXf x = place(samples_.u_px, middle_px.x());
  const Eigen::ArrayXf y = place(samples_.v_px, middle_px.y());
  for (; terms_set_ < wanted; ++terms_set_) {
    terms_[terms_set_].resize(samples_.size());
    Eigen::Map<Eigen::ArrayXf> term(terms_[terms_set_].data(), x.size());
    switch (terms_set_) {
      case 1: term = x; break;
      case 2: term = y; break;
      case 3: term = x.square() - y.square(); break;
      case 4: term = 2.0F * x * y; break;
      default: term = x.square() + y.square(); break;
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
    for (const Smear& smear : smears_[i]) {
      const Eigen::Vector2d at_px =
          parameters_.segment<2>(base(i) + 1) + smear.offset_px - samples_.origin_px;
      if (&smear == &smears_[i].front())
        images_[i].set_to(trial_.lamps[i], samples_.u_px, samples_.v_px, at_px, smear.weight);
      else
        images_[i].add_to(trial_.lamps[i], samples_.u_px, samples_.v_px, at_px, smear.weight);
    }
  list_rows(trial_);
  const auto terms = static_cast<std::size_t>(attempt_.background_terms);
  factor_.clear();
  for (Eigen::Index i = base(images_.size()); i < size(); ++i)
    factor_.push_back(static_cast<float>(parameters_[i]));
  set_rows(std::span(rows_).last(terms), factor_, {}, trial_.backdrop);
  shares_.assign(1, trial_.backdrop);
  factor_.assign(1, 1.0F);
  for (std::size_t i = 0; i < images_.size(); ++i) {
    shares_.emplace_back(trial_.lamps[i].share);
    factor_.push_back(static_cast<float>(scale_[base(i)]));
  }
  set_rows(shares_, factor_, samples_.others, trial_.expected);

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

void LampFitter::judge(std::span<const LampGuess> guesses) {
  const std::size_t clear = samples_.clear;
  std::array<LampRings, kMostLamps> rings;
  for (std::size_t i = 0; i < guesses.size(); ++i) {
    const double inner_px = std::max(guesses[i].rim_px - 1.0, 0.0);
    const double reach_px = attempt_.reach * reach_px_[i] - inner_px;
    const Eigen::Vector2f at_px =
        (parameters_.segment<2>(base(i) + 1) - samples_.origin_px).cast<float>();
    rings[i] = {at_px.x(), at_px.y(), static_cast<float>(inner_px),
                static_cast<float>(ResidualShape::kRings / reach_px)};
  }
  places_.resize(clear);
  set_places(PixelRow(samples_.u_px).first(clear), PixelRow(samples_.v_px).first(clear),
             PixelRow(samples_.keep).first(clear), std::span(rings).first(guesses.size()), places_);
  const auto row = [&](const std::vector<float>& all) {
    return Eigen::Map<const Eigen::ArrayXf>(all.data(), static_cast<Eigen::Index>(clear));
  };
  in_sigmas_ = row(accepted_.residual) * row(accepted_.weight).sqrt();
  ResidualShape shape(guesses.size(), coding_.correlated_px);
  for (std::size_t k = 0; k < clear; ++k)
    shape.add(places_[k], in_sigmas_[static_cast<Eigen::Index>(k)], accepted_.noise_share[k]);
  const ResidualShape::Verdict verdict =
      shape.verdict(static_cast<double>(per_lamp_), static_cast<double>(attempt_.background_terms));
  result_.chi2_per_dof = verdict.chi2_per_dof;
  result_.bad_fit = verdict.shaped;
  // A bend that takes nothing off what is left over says that no background leaves it.
  const bool bend_helps = !level_shape_ || verdict.shape < kBendHelps * *level_shape_;
  if (result_.attempt == 0) level_shape_ = verdict.shape;
  lamp_is_other_ =
      verdict.shaped && ((result_.attempt == kBent && (verdict.round || !bend_helps)) ||
                         (result_.attempt == 0 && verdict.round && !verdict.quarters_differ));
  result_.variance_factor = std::max(1.0, verdict.chi2_per_dof * coding_.summed_px);
  if (result_.bad_fit)
    result_.variance_factor = std::max(result_.variance_factor, verdict.shape_per_dof);
}

// How much of a pixel's light the fit takes from that pixel itself, over its weight: with a
// triangular root of the covariance, the sum of squares of each of its rows times the pixel's.
void LampFitter::find_leverage(const Matrix& covariance) {
  const Matrix root = covariance.llt().matrixU();
  factor_.clear();
  for (Eigen::Index i = 0; i < size(); ++i)
    for (Eigen::Index j = i; j < size(); ++j)
      factor_.push_back(static_cast<float>(root(i, j) * scale_[j]));
  leverage_.resize(samples_.clear);
  set_forms(rows_, factor_, leverage_);
}

// By what the residuals themselves say of their variance (Huber 1967). A residual counts as if its
// pixel had no part in the fit (MacKinnon and White 1985): where few pixels tell, about the rim,
// the fit follows them.
LampFitter::Matrix LampFitter::observed_covariance(const Matrix& inverse) {
  find_leverage(inverse);
  factor_ = accepted_.weight;
  const auto clear = static_cast<Eigen::Index>(samples_.clear);
  const auto row = [&](std::vector<float>& all) {
    return Eigen::Map<Eigen::ArrayXf>(all.data(), clear);
  };
  row(factor_) =
      (row(accepted_.pull) / (1.0F - row(accepted_.weight) * row(leverage_)).max(kLeastAlone))
          .square();
  const Matrix spread = coding_.summed_px * squares(factor_);
  return inverse.lazyProduct(spread.lazyProduct(inverse).eval());
}

LampFitter::Vector LampFitter::by_wing_share() {
  shares_.clear();
  factor_.clear();
  for (std::size_t i = 0; i < images_.size(); ++i) {
    shares_.emplace_back(accepted_.lamps[i].per_wing_share);
    factor_.push_back(static_cast<float>(scale_[base(i)]));
  }
  set_rows(shares_, factor_, {}, trial_.expected);
  const auto row = [&](std::vector<float>& all) {
    return Eigen::Map<Eigen::ArrayXf>(all.data(), static_cast<Eigen::Index>(samples_.size()));
  };
  row(trial_.expected) *= row(accepted_.weight);
  return products(trial_.expected);
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
  level_shape_.reset();
  coding_ = light.coding.value_or(CodingErrors{});
  per_lamp_ = radius_known ? 3 : 4;
  images_.assign(guesses.size(), image_);
  smear(guesses);
  gather(light, guesses, others);
  Sum sum;
  bool found = false;
  const auto tried = attempts(light);
  for (int k = first_attempt; k < static_cast<int>(tried.size()); ++k) {
    attempt_ = tried[static_cast<std::size_t>(k)];
    result_.attempt = k;
    samples_.keep_within(attempt_.reach);
    add_terms();
    found = fit_background(light, guesses, radius_known, found, sum);
    // Where the plainest backgrounds lead nowhere, a freer one takes the lamp's light for its own.
    if (!found && k >= kBent) break;
    const bool for_good = attempt_.background_terms != kNothingRound;
    if (found && (lamp_is_other_ || (for_good && !result_.bad_fit))) break;
  }
  if (!found) return result_;

  const Eigen::LDLT<Matrix> information(sum.information);
  if (information.info() != Eigen::Success || !information.isPositive()) return result_;
  const Matrix inverse = information.solve(Matrix::Identity(size(), size()));
  list_rows(accepted_);
  const Matrix informed = inverse * result_.variance_factor,
               observed = observed_covariance(inverse);
  const Vector by_wings = wing_share_sigma_ > 0.0
                              ? Vector(information.solve(by_wing_share()) * wing_share_sigma_)
                              : Vector::Zero(size());
  // Of a sum of parameters: the larger of the two, for the camera's electrons are not known.
  const auto sigma_of = [&](const Vector& factors) {
    const double variance =
        std::max(factors.dot(informed * factors), factors.dot(observed * factors));
    return std::hypot(std::sqrt(std::max(variance, 0.0)), by_wings.dot(factors));
  };
  const auto sigma = [&](Eigen::Index i) { return sigma_of(Vector::Unit(size(), i)); };
  for (std::size_t i = 0; i < guesses.size(); ++i) {
    const Eigen::Index at = base(i);
    LampFit lamp;
    lamp.flux = std::exp(parameters_[at]);
    const double coding_share =
        guesses[i].rim_px > 0.0 ? coding_.clipped_share : coding_.flux_share;
    lamp.log_flux_sigma_at_radius = std::hypot(sigma(at), coding_share);
    lamp.flux_sigma = lamp.flux * lamp.log_flux_sigma_at_radius;
    lamp.centre_px = parameters_.segment<2>(at + 1);
    for (Eigen::Index axis = 0; axis < 2; ++axis)
      lamp.centre_sigma_px[axis] = std::hypot(sigma(at + 1 + axis), coding_.centre_px);
    lamp.radius_px = images_[i].radius_px();
    if (per_lamp_ == 4) {
      lamp.radius_sigma_px = sigma(at + 3) / (2.0 * lamp.radius_px);
      const double per_radius2 = inverse(at, at + 3) / inverse(at + 3, at + 3);
      lamp.log_flux_per_radius = 2.0 * lamp.radius_px * per_radius2;
      Vector at_radius = Vector::Unit(size(), at);
      at_radius[at + 3] = -per_radius2;
      lamp.log_flux_sigma_at_radius = std::hypot(sigma_of(at_radius), coding_share);
    }
    result_.lamps.push_back(lamp);
  }
  result_.background = parameters_[base(guesses.size())];
  result_.background_sigma = sigma(base(guesses.size()));
  return result_;
}

}  // namespace vildar
