#include "calib/psf/joint_fit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "detect/censored.h"
#include "optics/disc_image.h"

namespace vildar {
namespace {

constexpr double kPatch_px2 = 16.0;  // area whose background is uneven together
constexpr double kMostPixels = 1500.0;
constexpr double kRimInside_px = 5.0, kHoleDepth_px = 1.5, kHoleLight = 0.8;
constexpr double kFar = 3.0;    // sigmas: pixels further off weigh less (Huber 1964)
constexpr double kStep = 0.02;  // of a number of the PSF, for its derivatives
constexpr int kMostOwnSteps = 30, kMostPsfSteps = 30;
constexpr double kOwnDone = 1e-4, kPsfDone = 0.01;  // expected fall of the sum of squares
constexpr double kMostMove = 0.3;                   // of a number of the PSF, in a step
constexpr double kLeastRadius_px = 0.1;
constexpr int kPerLamp = 4;
const PsfVector kLow{std::log(0.52), std::log(1e-4), std::log(0.55), std::log(0.05)};
const PsfVector kHigh{std::log(8.0), std::log(0.8), std::log(50.0), std::log(6.0)};

// Pictures behind PSFs beside the one in force, for derivatives by its numbers.
class PsfSlopes {
 public:
  explicit PsfSlopes(const PsfVector& psf) : wing_share_(shape_of(psf).wing_share) {
    for (const int k : {0, 2, 3})
      for (const double sign : {1.0, -1.0}) {
        PsfVector beside = psf;
        beside[k] += sign * kStep;
        images_.emplace_back(shape_of(beside));
      }
  }
  void set_radius(double radius_px) {
    for (DiscImage& image : images_) image.set_radius(radius_px);
  }
  /// Of the pixel (du, dv) from the disc's centre.
  PsfVector at(double du_px, double dv_px, double per_wing_share) const {
    const auto slope = [&](std::size_t i) {
      return (images_[i].at(du_px, dv_px).share - images_[i + 1].at(du_px, dv_px).share) /
             (2.0 * kStep);
    };
    return {slope(0), per_wing_share * wing_share_, slope(2), slope(4)};
  }

 private:
  double wing_share_;
  std::vector<DiscImage> images_;
};

std::array<double, 6> background_terms(const CropFit& fit, const CropFit::Pixel& pixel) {
  const double x = (pixel.u - fit.middle_px.x()) / fit.unit_px;
  const double y = (pixel.v - fit.middle_px.y()) / fit.unit_px;
  return {1.0, x, y, x * x - y * y, 2.0 * x * y, x * x + y * y};
}

// Residuals of a crop over its pixels' sigmas, and how they change with what is fitted.
struct Linear {
  Eigen::VectorXd residual;
  Eigen::MatrixXd by_own, by_psf;  // the latter where asked for
};

Linear linearised(const CropFit& fit, DiscImage& image, PsfSlopes* slopes) {
  const auto n = static_cast<Eigen::Index>(fit.pixels.size());
  const auto width = static_cast<Eigen::Index>(fit.own.size());
  const auto lamps = static_cast<Eigen::Index>(kPerLamp * fit.crop->lamps.size());
  Linear linear;
  linear.residual.resize(n);
  linear.by_own.setZero(n, width);
  if (slopes != nullptr) linear.by_psf.setZero(n, kPsfNumbers);
  Eigen::VectorXd model = Eigen::VectorXd::Zero(n);
  for (Eigen::Index lamp = 0; lamp < lamps; lamp += kPerLamp) {
    const double* of = fit.own.data() + lamp;
    const double flux = std::exp(of[0]), disc_px = radius_px(of[3]);
    image.set_radius(disc_px);
    if (slopes != nullptr) slopes->set_radius(disc_px);
    for (Eigen::Index i = 0; i < n; ++i) {
      const CropFit::Pixel& pixel = fit.pixels[static_cast<std::size_t>(i)];
      const double du = pixel.u - of[1], dv = pixel.v - of[2];
      const DiscImage::Pixel at = image.at(du, dv);
      model[i] += flux * at.share;
      linear.by_own.row(i).segment<4>(lamp) << flux * at.share, flux * at.per_u, flux * at.per_v,
          flux * at.per_radius * of[3] / disc_px;
      if (slopes != nullptr)
        linear.by_psf.row(i) += flux * slopes->at(du, dv, at.per_wing_share).transpose();
    }
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    const CropFit::Pixel& pixel = fit.pixels[static_cast<std::size_t>(i)];
    const auto terms = background_terms(fit, pixel);
    for (Eigen::Index k = lamps; k < width; ++k) {
      linear.by_own(i, k) = terms[static_cast<std::size_t>(k - lamps)];
      model[i] += fit.own[static_cast<std::size_t>(k)] * linear.by_own(i, k);
    }
    double slope = -pixel.weight;
    linear.residual[i] = pixel.weight * (pixel.light - model[i]);
    if (pixel.clipped) {
      const Censored censored((model[i] - pixel.light) * pixel.weight);
      linear.residual[i] = std::sqrt(censored.cost);
      slope = censored.cost > 1e-18 ? -censored.slope / linear.residual[i] * pixel.weight : 0.0;
    }
    linear.by_own.row(i) *= slope;
    if (slopes != nullptr) linear.by_psf.row(i) *= slope;
  }
  return linear;
}

// Levenberg and Marquardt over what the crop has of its own; the sum of squares reached.
double fit_own(CropFit& fit, DiscImage& image) {
  Linear at = linearised(fit, image, nullptr);
  double cost = at.residual.squaredNorm(), damping = 1e-4;
  for (int i = 0; i < kMostOwnSteps; ++i) {
    Eigen::MatrixXd information = at.by_own.transpose() * at.by_own;
    const Eigen::VectorXd score = -at.by_own.transpose() * at.residual;
    information.diagonal() *= 1.0 + damping;
    information.diagonal().array() += 1e-12 * information.diagonal().maxCoeff();
    Eigen::VectorXd move = information.ldlt().solve(score);
    if (!move.allFinite()) return cost;
    const double gain = move.dot(score);
    if (gain < kOwnDone && damping < 1.0) return cost;
    for (std::size_t lamp = 0; lamp < fit.crop->lamps.size(); ++lamp) {
      auto own = move.segment<4>(static_cast<Eigen::Index>(kPerLamp * lamp));
      own = own.cwiseMax(-1.0).cwiseMin(1.0);
    }
    CropFit trial = fit;
    for (std::size_t k = 0; k < trial.own.size(); ++k)
      trial.own[k] += move[static_cast<Eigen::Index>(k)];
    bool inside = true;
    for (std::size_t lamp = 0; lamp < fit.crop->lamps.size(); ++lamp)
      inside &= radius_px(trial.own[kPerLamp * lamp + 3]) < DiscImage::kMostRadius_px;
    Linear there;
    if (inside) there = linearised(trial, image, nullptr);
    if (inside && there.residual.squaredNorm() <= cost) {
      fit.own = std::move(trial.own);
      at = std::move(there);
      cost = at.residual.squaredNorm();
      damping = std::max(0.1 * damping, 1e-9);
    } else {
      damping = std::max(10.0 * damping, 1e-3);
      if (damping > 1e8) return cost;
    }
  }
  return cost;
}

double prior_cost(const PsfVector& psf) {
  double cost = 0.0;
  for (int k = 0; k < kPsfNumbers; ++k)
    if (psf_prior().std[k] > 0.0)
      cost += std::pow((psf[k] - psf_prior().mean[k]) / psf_prior().std[k], 2);
  return cost;
}

}  // namespace

PsfVector numbers_of(const PsfShape& shape) {
  return {std::log(shape.core_sigma_px), std::log(shape.wing_share), std::log(shape.wing_scale_px),
          std::log(shape.wing_exponent - 2.0)};
}

PsfShape shape_of(const PsfVector& numbers) {
  return {std::exp(numbers[0]), std::exp(numbers[1]), std::exp(numbers[2]),
          2.0 + std::exp(numbers[3])};
}

const PsfPrior& psf_prior() {
  static const PsfPrior prior{numbers_of({1.0, 0.03, 2.0, 2.7}), {0.0, 1.5, 1.0, 1.0}};
  return prior;
}

double radius_px(double number) { return std::hypot(kLeastRadius_px, number); }

double radius_number(double radius_px) {
  return std::sqrt(std::max(radius_px * radius_px - kLeastRadius_px * kLeastRadius_px, 0.01));
}

void gather_pixels(CropFit& fit) {
  const FrameLight& light = fit.crop->light;
  const std::vector<LampGuess>& lamps = fit.crop->lamps;
  fit.pixels.clear();
  fit.middle_px = Eigen::Vector2d::Zero();
  fit.unit_px = 0.0;
  for (const LampGuess& lamp : lamps) {
    fit.middle_px += lamp.centre_px / static_cast<double>(lamps.size());
    fit.unit_px = std::max(fit.unit_px, LampFitter::reach_px(lamp.rim_px, lamp.size_px, 1.5));
  }
  for (int v = 0; v < light.luma.height_px; ++v)
    for (int u = 0; u < light.luma.width_px; ++u) {
      bool reached = false, left_out = false, inside = false;
      for (const LampGuess& lamp : lamps) {
        const double from_px = (Eigen::Vector2d(u, v) - lamp.centre_px).norm();
        const double reach_px = LampFitter::reach_px(lamp.rim_px, lamp.size_px, 1.5);
        reached |= from_px <= fit.attempt.reach * reach_px;
        left_out |= from_px < lamp.rim_px - kRimInside_px;
        inside |= from_px < lamp.rim_px - kHoleDepth_px;
      }
      if (!reached || left_out) continue;
      const int code = light.luma.code(u, v);
      const double here = static_cast<double>(light.linear[static_cast<std::size_t>(code)]);
      const bool clipped =
          code >= light.clip_code || (inside && here > kHoleLight * light.clip_light);
      fit.pixels.push_back({u, v, clipped ? light.clip_light : here, clipped, 0.0});
    }
  const auto stride =
      static_cast<int>(std::ceil(static_cast<double>(fit.pixels.size()) / kMostPixels));
  if (stride > 1)
    std::erase_if(fit.pixels,
                  [&](const CropFit::Pixel& one) { return (one.u + 2 * one.v) % stride != 0; });
}

void weigh_pixels(CropFit& fit, const PsfShape& shape) {
  DiscImage image(shape);
  const FrameLight& light = fit.crop->light;
  const std::size_t n = fit.pixels.size();
  std::vector<double> lamps_light(n), residual(n), spread;
  const std::size_t lamps = kPerLamp * fit.crop->lamps.size();
  for (std::size_t lamp = 0; lamp < lamps; lamp += kPerLamp) {
    image.set_radius(radius_px(fit.own[lamp + 3]));
    for (std::size_t i = 0; i < n; ++i)
      lamps_light[i] +=
          std::exp(fit.own[lamp]) *
          image.at(fit.pixels[i].u - fit.own[lamp + 1], fit.pixels[i].v - fit.own[lamp + 2]).share;
  }
  for (std::size_t i = 0; i < n; ++i) {
    CropFit::Pixel& pixel = fit.pixels[i];
    const auto terms = background_terms(fit, pixel);
    double backdrop = 0.0;
    for (std::size_t k = lamps; k < fit.own.size(); ++k) backdrop += fit.own[k] * terms[k - lamps];
    const double uneven = fit.attempt.uneven * std::max(backdrop, 0.0);
    const double expected = pixel.clipped ? light.clip_light : lamps_light[i] + backdrop;
    const double variance = light.noise.variance(expected) + kPatch_px2 * uneven * uneven;
    pixel.weight = 1.0 / std::sqrt(variance);
    residual[i] = pixel.clipped ? 0.0 : (pixel.light - expected) * pixel.weight;
    if (!pixel.clipped) spread.push_back(std::abs(residual[i]));
  }
  fit.scale = 1.0;
  if (!spread.empty()) {
    const auto middle = spread.begin() + static_cast<std::ptrdiff_t>(spread.size() / 2);
    std::nth_element(spread.begin(), middle, spread.end());
    fit.scale = std::max(1.0, *middle / 0.6745);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const double far = std::abs(residual[i]) / (fit.scale * kFar);
    fit.pixels[i].weight /= fit.scale * std::sqrt(std::max(1.0, far));
  }
}

bool solve_jointly(std::vector<CropFit>& fits, PsfVector& psf) {
  const auto fit_all = [](std::vector<CropFit>& all, const PsfVector& numbers) {
    DiscImage image(shape_of(numbers));
    double cost = prior_cost(numbers);
    for (CropFit& fit : all) cost += fit_own(fit, image);
    return cost;
  };
  double cost = fit_all(fits, psf), damping = 1e-3;
  for (int i = 0; i < kMostPsfSteps; ++i) {
    PsfEvidence sum = psf_prior_evidence(psf);
    for (const PsfEvidence& one : evidence_of(fits, psf)) {
      sum.information += one.information;
      sum.score += one.score;
    }
    for (;;) {
      PsfMatrix damped = sum.information;
      damped.diagonal() *= 1.0 + damping;
      const PsfVector move =
          damped.ldlt().solve(sum.score).cwiseMax(-kMostMove).cwiseMin(kMostMove);
      if (!move.allFinite()) return false;
      if (move.dot(sum.score) < kPsfDone) return true;
      const PsfVector there = (psf + move).cwiseMax(kLow).cwiseMin(kHigh);
      std::vector<CropFit> trial = fits;
      const double trial_cost = fit_all(trial, there);
      if (trial_cost < cost) {
        const bool done = cost - trial_cost < kPsfDone;
        cost = trial_cost;
        psf = there;
        fits = std::move(trial);
        damping = std::max(0.2 * damping, 1e-6);
        if (done) return true;
        break;
      }
      damping *= 8.0;
      if (damping > 1e6) return true;  // as far down as the rounding of the tables allows
    }
  }
  return true;
}

PsfEvidence psf_prior_evidence(const PsfVector& psf) {
  PsfEvidence evidence;
  for (int k = 0; k < kPsfNumbers; ++k) {
    if (!(psf_prior().std[k] > 0.0)) continue;
    const double weight = 1.0 / (psf_prior().std[k] * psf_prior().std[k]);
    evidence.information(k, k) = weight;
    evidence.score[k] = weight * (psf_prior().mean[k] - psf[k]);
  }
  return evidence;
}

std::vector<PsfEvidence> evidence_of(std::span<const CropFit> fits, const PsfVector& psf) {
  DiscImage image(shape_of(psf));
  PsfSlopes slopes(psf);
  std::vector<PsfEvidence> found;
  for (const CropFit& fit : fits) {
    const Linear linear = linearised(fit, image, &slopes);
    // What the crop's own unknowns cannot imitate.
    const Eigen::MatrixXd own = linear.by_own.transpose() * linear.by_own;
    const Eigen::MatrixXd both = linear.by_own.transpose() * linear.by_psf;
    const Eigen::VectorXd own_score = -linear.by_own.transpose() * linear.residual;
    const Eigen::MatrixXd imitated = own.ldlt().solve(both);
    PsfEvidence evidence;
    evidence.information = linear.by_psf.transpose() * linear.by_psf - both.transpose() * imitated;
    evidence.score =
        -linear.by_psf.transpose() * linear.residual - imitated.transpose() * own_score;
    found.push_back(evidence);
  }
  return found;
}

}  // namespace vildar
