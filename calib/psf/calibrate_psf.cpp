#include "calib/psf/calibrate_psf.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <Eigen/Dense>

#include "calib/psf/joint_fit.h"
#include "optics/disc_image.h"

namespace vildar {
namespace {

constexpr std::size_t kLeastCrops = 8;
constexpr double kLeastKeptShare = 0.25;
constexpr int kMostRounds = 5;
constexpr double kSettled = 0.2;          // of a sigma
constexpr double kMostShareSpread = 0.7;  // sigma of ln share that is still worth having
constexpr double kToldShare = 0.6;        // of a prior's sigma
// By how much coding with loss moves the numbers beyond what their scatter shows: it erases wings
// and reshapes rims alike in all pictures. RMS over passes of known lamps through H.264
// (docs/photometry.md).
const PsfVector kCodingDoubt{0.2, 0.65, 0.95, 1.2};
constexpr LampFitter::Attempt kFreely{5, 1.0, 0.1};
constexpr double kCoreSeen = 5.0;  // times white up to which the flank of the core shows

struct Round {
  std::vector<CropFit> fits;
  std::map<std::string, int> left_out;
  std::vector<double> chi2_per_dof;
  int shaped = 0;
};

// Each crop's lamps under the PSF as it stands.
Round start_round(std::span<const LampCrop> crops, std::span<const std::vector<LampGuess>> guesses,
                  const PsfShape& shape, bool judge) {
  Round round;
  LampFitter fitter(shape);
  for (std::size_t i = 0; i < crops.size(); ++i) {
    const LampCrop& crop = crops[i];
    const auto attempts = LampFitter::attempts(crop.light);
    const int freest = static_cast<int>(attempts.size()) - 1;
    LampsFit found = fitter.fit(crop.light, guesses[i], false, {}, judge ? 0 : freest);
    // What the last round began from may be another summit.
    if (judge && found.bad_fit) found = fitter.fit(crop.light, crop.lamps, false);
    if (found.lamps.empty()) {
      ++round.left_out["not_fitted"];
      continue;
    }
    round.shaped += found.bad_fit;
    round.chi2_per_dof.push_back(found.chi2_per_dof);
    if (judge && found.bad_fit) {
      ++round.left_out["shaped_residuals"];
      continue;
    }
    CropFit fit;
    fit.crop = &crop;
    fit.attempt = judge ? attempts[static_cast<std::size_t>(found.attempt)] : kFreely;
    for (const LampFit& lamp : found.lamps)
      fit.own.insert(fit.own.end(), {std::log(lamp.flux), lamp.centre_px.x(), lamp.centre_px.y(),
                                     radius_number(lamp.radius_px)});
    fit.own.push_back(found.background);
    fit.own.resize(fit.own.size() + static_cast<std::size_t>(fit.attempt.background_terms) - 1);
    gather_pixels(fit);
    if (fit.pixels.size() > 4 * fit.own.size()) round.fits.push_back(std::move(fit));
  }
  return round;
}

// Where the next round begins.
void learn(const Round& round, const LampCrop* first, std::span<std::vector<LampGuess>> guesses) {
  for (const CropFit& fit : round.fits)
    for (std::size_t lamp = 0; lamp < fit.crop->lamps.size(); ++lamp) {
      LampGuess& guess = guesses[static_cast<std::size_t>(fit.crop - first)][lamp];
      guess.flux = std::exp(fit.own[4 * lamp]);
      guess.radius_px = radius_px(fit.own[4 * lamp + 3]);
    }
}

PsfVector joined(const PsfVector& a, const PsfVector& b) {
  return a.binaryExpr(b, [](double x, double y) { return std::hypot(x, y); });
}

bool solve(Round& round, PsfVector& psf) {
  for (int pass = 0; pass < 2; ++pass) {
    for (CropFit& fit : round.fits) weigh_pixels(fit, shape_of(psf));
    if (!solve_jointly(round.fits, psf)) return false;
  }
  return true;
}

// The larger, number by number, of what the crops' information says and what the scatter of their
// scores does, one lamp's crops together (Liang and Zeger 1986).
PsfVector sigmas_of(Round& round, const PsfVector& psf) {
  const std::vector<PsfEvidence> evidence = evidence_of(round.fits, psf);
  PsfMatrix information = psf_prior_evidence(psf).information;
  std::map<int, PsfVector> by_lamp;
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    information += evidence[i].information;
    const auto place = by_lamp.try_emplace(round.fits[i].crop->lamp_id, PsfVector::Zero()).first;
    place->second += evidence[i].score;
  }
  const PsfMatrix covariance = information.ldlt().solve(PsfMatrix::Identity());
  PsfMatrix scatter = PsfMatrix::Zero();
  for (const auto& [lamp, score] : by_lamp) scatter += score * score.transpose();
  const auto lamps = static_cast<double>(by_lamp.size());
  scatter *= lamps / std::max(lamps - kPsfNumbers, 1.0);
  const PsfMatrix robust = covariance * scatter * covariance;
  return covariance.diagonal().cwiseMax(robust.diagonal()).cwiseSqrt();
}

void describe(const Round& round, const PsfShape& shape, PsfCalibration& found) {
  std::set<int> lamps;
  std::set<std::int64_t> frames;
  DiscImage image(shape);
  bool core_seen = false;
  for (const CropFit& fit : round.fits) {
    lamps.insert(fit.crop->lamp_id);
    frames.insert(fit.crop->frame);
    for (std::size_t lamp = 0; lamp < fit.crop->lamps.size(); ++lamp) {
      image.set_radius(radius_px(fit.own[4 * lamp + 3]));
      const double times_white = std::exp(fit.own[4 * lamp]) * image.at(0.0, 0.0).share;
      core_seen |= times_white < kCoreSeen;
      const double decade = std::ceil(std::log10(std::max(times_white, 1e-3)));
      ++found.by_brightness[static_cast<std::size_t>(std::clamp(decade, 0.0, 4.0))];
    }
  }
  found.wings_from_clipped_alone = !core_seen;
  found.crops = static_cast<int>(round.fits.size());
  found.lamps = static_cast<int>(lamps.size());
  found.frames = static_cast<int>(frames.size());
  found.left_out = round.left_out;
  std::vector<double> chi2 = round.chi2_per_dof;
  const auto middle = chi2.begin() + static_cast<std::ptrdiff_t>(chi2.size() / 2);
  std::nth_element(chi2.begin(), middle, chi2.end());
  found.chi2_per_dof = *middle;
  found.shaped_share = round.shaped / static_cast<double>(chi2.size());
}

}  // namespace

Outcome<PsfCalibration> calibrate_psf(std::span<const LampCrop> crops, bool lossy) {
  if (crops.size() < kLeastCrops) return Miss::too_few_samples;
  PsfVector psf = psf_prior().mean;
  std::vector<std::vector<LampGuess>> guesses;
  for (const LampCrop& crop : crops) guesses.push_back(crop.lamps);
  Round round = start_round(crops, guesses, shape_of(psf), false);
  if (round.fits.size() < kLeastCrops) return Miss::bad_fit;
  if (!solve(round, psf)) return Miss::not_converged;
  PsfVector sigmas = sigmas_of(round, psf);
  bool settled = false;
  for (int i = 0; i < kMostRounds && !settled; ++i) {
    const PsfVector before = psf;
    // The first rounds' PSF is too rough to judge by.
    learn(round, crops.data(), guesses);
    round = start_round(crops, guesses, shape_of(psf), !lossy && i > 0);
    if (round.fits.size() < kLeastCrops || static_cast<double>(round.fits.size()) <
                                               kLeastKeptShare * static_cast<double>(crops.size()))
      return Miss::bad_fit;
    if (!solve(round, psf)) return Miss::not_converged;
    sigmas = sigmas_of(round, psf);
    const PsfVector moved = (psf - before).cwiseAbs();
    settled = i > 0 && (moved.array() < kSettled * sigmas.array()).all();
    // Where the rounds do not come to rest, they tell how far the answer wanders.
    if (i + 1 == kMostRounds) sigmas = joined(sigmas, moved);
  }
  if (!(sigmas[1] < kMostShareSpread)) return Miss::unobservable;
  if (lossy) sigmas = joined(sigmas, kCodingDoubt);

  PsfCalibration found;
  found.psf.shape = shape_of(psf);
  const PsfShape& shape = found.psf.shape;
  found.core_sigma_std_px = sigmas[0] * shape.core_sigma_px;
  found.psf.wing_share_std = sigmas[1] * shape.wing_share;
  found.wing_scale_std_px = sigmas[2] * shape.wing_scale_px;
  found.wing_exponent_std = sigmas[3] * (shape.wing_exponent - 2.0);
  static constexpr const char* kKeys[] = {"core_sigma_px", "wing_share", "wing_scale_px",
                                          "wing_exponent"};
  for (int k = 0; k < kPsfNumbers; ++k)
    if (psf_prior().std[k] > 0.0 && sigmas[k] > kToldShare * psf_prior().std[k])
      found.undetermined.emplace_back(kKeys[k]);
  describe(round, shape, found);
  return found;
}

}  // namespace vildar
