#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "calib/psf/lamp_crops.h"

namespace vildar {

/// A PSF as it is fitted: ln core sigma, ln wing share, ln wing scale, ln (wing exponent - 2).
constexpr int kPsfNumbers = 4;
using PsfVector = Eigen::Matrix<double, kPsfNumbers, 1>;
using PsfMatrix = Eigen::Matrix<double, kPsfNumbers, kPsfNumbers>;
PsfVector numbers_of(const PsfShape& shape);
PsfShape shape_of(const PsfVector& numbers);

/// What is thought of any camera's PSF before a lamp was seen, so that what lamps do not tell stays
/// finite; a std of 0 is no prior.
struct PsfPrior {
  PsfVector mean, std;
};
const PsfPrior& psf_prior();

/// A crop and what is fitted to it beside the PSF.
struct CropFit {
  const LampCrop* crop = nullptr;
  LampFitter::Attempt attempt{};  ///< at the background
  /// Of each lamp ln flux, centre and what radius_px() takes; then the background, a polynomial of
  /// the place about `middle_px` in `unit_px`.
  std::vector<double> own;
  Eigen::Vector2d middle_px = Eigen::Vector2d::Zero();
  double unit_px = 1.0;
  struct Pixel {
    int u, v;
    double light;
    bool clipped;
    double weight;  ///< one over sigma
  };
  std::vector<Pixel> pixels;
  double scale = 1.0;  ///< of the residuals, by which their sigmas were widened
};

/// The disc's radius is fitted as a number that may have any value: a point is 0.
double radius_px(double number);
double radius_number(double radius_px);

/// Takes the crop's pixels within the attempt's reach of its lamps.
void gather_pixels(CropFit& fit);

/// Weighs the pixels by the variances of the fit as it stands, wider where they scatter more, and
/// those far off less.
void weigh_pixels(CropFit& fit, const PsfShape& shape);

/// What one crop says of the PSF with its own unknowns eliminated.
struct PsfEvidence {
  PsfMatrix information = PsfMatrix::Zero();
  PsfVector score = PsfVector::Zero();
};
std::vector<PsfEvidence> evidence_of(std::span<const CropFit> fits, const PsfVector& psf);
PsfEvidence psf_prior_evidence(const PsfVector& psf);

/// Least squares over the PSF and all crops' lamps and backgrounds: each crop's own are fitted anew
/// for every PSF that is tried. Weights stay. False where no step can be computed.
bool solve_jointly(std::vector<CropFit>& fits, PsfVector& psf);

}  // namespace vildar
