// Photometry and centres of single lamps against the bound and the truth; prints the tables of
// docs/photometry.md.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <cstdio>

#include "core/quantity.h"
#include "detect/gaussian_spot.h"
#include "detect/lamp_fit.h"
#include "detect/lamp_pictures.h"
#include "detect/linear_camera.h"

namespace vildar {
namespace {

class LampFitStudy : public testing::Test {
 protected:
  void SetUp() override {
#ifndef NDEBUG
    GTEST_SKIP() << "studies need an optimised build (preset bench or ci)";
#endif
  }
};

TEST_F(LampFitStudy, UnsaturatedSpotsAreMeasuredAtTheBound) {
  constexpr int kTrials = 10000;
  // A standard deviation is known to 1 / sqrt(2 n); two axes for the centre. Three of those.
  constexpr double kCentreRatio = 1.05 + 3.0 * 0.005, kFluxRatio = 1.05 + 3.0 * 0.0071;
  const LinearCamera camera;
  std::printf("%6s %6s | %9s %7s %9s | %8s %7s %9s | %7s\n", "sigma", "peak", "centre px", "ratio",
              "bias px", "flux %", "ratio", "bias %", "flagged");
  for (const double sigma_px : {0.7, 1.0, 1.5, 2.5, 4.0}) {
    LampFitter fitter(PsfShape{sigma_px, 0.0, 2.0, 2.5});
    const int size_px = 2 * static_cast<int>(std::ceil(5.0 * sigma_px + 4.0)) + 1;
    for (const double peak : {0.01, 0.03, 0.3, 0.9}) {
      const double flux = peak * 2.0 * kPi * sigma_px * sigma_px;
      Random random(31);
      Eigen::Vector2d bias_px = Eigen::Vector2d::Zero();
      double square_px2 = 0.0, bias = 0.0, square = 0.0, bound_px2 = 0.0, bound = 0.0;
      int found = 0, flagged = 0;
      for (int trial = 0; trial < kTrials; ++trial) {
        const Eigen::Vector2d at(size_px / 2 + random.uniform(-0.5, 0.5),
                                 size_px / 2 + random.uniform(-0.5, 0.5));
        const GaussianSpot spot(size_px, at.x(), at.y(), sigma_px, flux);
        const FrameLight frame = camera.expose(spot.light, size_px, random);
        LampGuess guess;
        guess.centre_px =
            at + Eigen::Vector2d(random.uniform(-0.4, 0.4), random.uniform(-0.4, 0.4));
        guess.size_px = sigma_px;
        guess.radius_px = 0.0;
        const LampsFit& fit = fitter.fit(frame, {{guess}}, true);
        if (fit.lamps.empty()) continue;
        ++found;
        flagged += fit.bad_fit;
        const Eigen::Vector2d off_px = fit.lamps[0].centre_px - at;
        const double off = fit.lamps[0].flux / flux - 1.0;
        bias_px += off_px;
        square_px2 += 0.5 * off_px.squaredNorm();
        bias += off;
        square += off * off;
        bound_px2 += spot.centre_variance;
        bound += spot.flux_variance / (flux * flux);
      }
      const double centre_ratio = std::sqrt(square_px2 / bound_px2);
      const double flux_ratio = std::sqrt(square / bound);
      std::printf("%6.1f %6.2f | %9.4f %7.3f %9.5f | %8.3f %7.3f %9.4f | %6.2f%%\n", sigma_px, peak,
                  std::sqrt(square_px2 / found), centre_ratio,
                  bias_px.cwiseAbs().maxCoeff() / found, 100.0 * std::sqrt(square / found),
                  flux_ratio, 100.0 * bias / found, 100.0 * flagged / found);
      EXPECT_GE(found, kTrials * 999 / 1000);
      EXPECT_LT(centre_ratio, kCentreRatio) << sigma_px << " " << peak;
      EXPECT_LT(flux_ratio, kFluxRatio) << sigma_px << " " << peak;
      // What the number of trials leaves open, four sigmas of it, is no bias.
      EXPECT_LT(bias_px.cwiseAbs().maxCoeff() / found, 0.002 + 4.0 * std::sqrt(square_px2) / found);
      if (peak >= 0.03) {
        EXPECT_LT(std::abs(bias / found), 0.002 + 4.0 * std::sqrt(square) / found);
      }
      EXPECT_LT(flagged, 0.05 * found);
    }
  }
}

/// Bounds of ln flux and of the centre of a lamp that clips, with radius and a level background
/// free: the information of all pixels of a picture, normal with the variance of their light and
/// cut off at the clipping light. Slopes are differences of the renderer's pictures.
struct ClippedBound {
  double flux = 0.0, centre_px = 0.0;  ///< standard deviations

  ClippedBound(const LampPictures& pictures, const FrameLight& frame, double disc_px,
               double flux_in, bool size_known) {
    constexpr int kPlaces = 6;
    constexpr double kStep = 0.02;
    Random random(33);
    const int free = size_known ? 4 : 5;
    for (int place = 0; place < kPlaces; ++place) {
      const double u = 40.0 + random.uniform(-0.5, 0.5), v = 40.0 + random.uniform(-0.5, 0.5);
      const auto picture = [&](double du, double dv, double radius) {
        return pictures.of({LampPictures::lamp(u + du, v + dv, disc_px + radius, flux_in)});
      };
      const std::vector<double> at = picture(0.0, 0.0, 0.0);
      std::vector<std::vector<double>> slopes{at};
      for (const Eigen::Vector3d& step :
           {Eigen::Vector3d(kStep, 0.0, 0.0), {0.0, kStep, 0.0}, {0.0, 0.0, kStep}}) {
        slopes.push_back(picture(step.x(), step.y(), step.z()));
        const std::vector<double> before = picture(-step.x(), -step.y(), -step.z());
        for (std::size_t i = 0; i < at.size(); ++i)
          slopes.back()[i] = (slopes.back()[i] - before[i]) / (2.0 * kStep);
      }
      Eigen::MatrixXd information = Eigen::MatrixXd::Zero(free, free);
      for (std::size_t i = 0; i < at.size(); ++i) {
        const double variance = LinearCamera::variance(at[i]);
        const double light = at[i] + LinearCamera::kBackground_e / LinearCamera::kFullWell_e;
        const double a = (frame.clip_light - light) / std::sqrt(variance);
        if (a < -8.0) continue;
        const double density = std::exp(-0.5 * a * a) / std::sqrt(2.0 * kPi);
        const double above = 0.5 * std::erfc(a / std::sqrt(2.0));
        const double seen =
            1.0 - above - a * density + (above > 0.0 ? density * density / above : 0.0);
        Eigen::VectorXd gradient(free);
        gradient << slopes[0][i], slopes[1][i], slopes[2][i], 1.0, Eigen::VectorXd(free - 4);
        if (!size_known) gradient[4] = slopes[3][i];
        information += seen / variance * gradient * gradient.transpose();
      }
      const Eigen::MatrixXd covariance = information.inverse();
      flux += covariance(0, 0) / kPlaces;
      centre_px += 0.5 * (covariance(1, 1) + covariance(2, 2)) / kPlaces;
    }
    flux = std::sqrt(flux);
    centre_px = std::sqrt(centre_px);
  }
};

struct SaturatedCell {
  double bias = 0.0, rmse = 0.0, centre_px = 0.0, coverage = 0.0, flagged = 0.0, aperture = 0.0;
  int found = 0;
};

SaturatedCell measured(LampPictures& pictures, LampFitter& fitter, double disc_px, double times,
                       bool size_known, int trials) {
  constexpr int kSize_px = 81;
  const LinearCamera camera;
  Random random(32);
  SaturatedCell cell;
  const double flux = pictures.flux(disc_px, times);
  for (int trial = 0; trial < trials; ++trial) {
    const double u = 40.0 + random.uniform(-0.5, 0.5), v = 40.0 + random.uniform(-0.5, 0.5);
    const FrameLight frame =
        camera.expose(pictures.of({LampPictures::lamp(u, v, disc_px, flux)}), kSize_px, random);
    LampGuess guess = guess_of(frame, std::hypot(0.9, 0.5 * disc_px));
    if (size_known) guess.radius_px = disc_px;
    const LampsFit& fit = fitter.fit(frame, {{guess}}, size_known);
    if (fit.lamps.empty()) continue;
    const LampFit& lamp = fit.lamps[0];
    ++cell.found;
    const double off = lamp.flux / flux - 1.0;
    cell.bias += off;
    cell.rmse += off * off;
    cell.centre_px += 0.5 * (lamp.centre_px - Eigen::Vector2d(u, v)).squaredNorm();
    cell.coverage += std::abs(lamp.flux - flux) < 1.96 * lamp.flux_sigma;
    cell.flagged += fit.bad_fit;
    double sum = 0.0;
    for (int y = 0; y < kSize_px; ++y)
      for (int x = 0; x < kSize_px; ++x)
        if (std::hypot(x - u, y - v) < 12.0)
          sum += static_cast<double>(frame.linear[frame.luma.code(x, y)]) - 0.002;
    cell.aperture += sum / flux - 1.0;
  }
  cell.bias /= cell.found;
  cell.rmse = std::sqrt(cell.rmse / cell.found);
  cell.centre_px = std::sqrt(cell.centre_px / cell.found);
  cell.coverage /= cell.found;
  // A lamp without a fit keeps its plain measures, as one does that is flagged.
  cell.flagged = (cell.flagged + trials - cell.found) / trials;
  cell.aperture /= cell.found;
  return cell;
}

constexpr int kSaturatedTrials = 400;

TEST_F(LampFitStudy, SaturatedLampsKeepTheirFlux) {
  const PsfShape glare{0.9, 0.03, 2.0, 2.5};
  LampPictures pictures(glare, 81);
  LampFitter fitter(glare);
  Random random(34);
  const FrameLight any = LinearCamera().expose(std::vector<double>(1, 0.0), 1, random);
  std::printf("%5s %5s %6s | %8s %7s %6s %9s %6s %9s %8s %6s | %9s\n", "size", "disc", "times",
              "bias %", "rmse %", "ratio", "centre px", "ratio", "coverage", "flagged", "found",
              "aperture");
  for (const bool size_known : {true, false})
    for (const double disc_px : {0.5, 3.0, 6.0}) {
      double first_ln = 0.0, last_ln = 0.0;
      for (const double times : {2.0, 5.0, 20.0, 100.0, 500.0, 2000.0}) {
        const SaturatedCell cell =
            measured(pictures, fitter, disc_px, times, size_known, kSaturatedTrials);
        const ClippedBound bound(pictures, any, disc_px, pictures.flux(disc_px, times), size_known);
        std::printf("%5s %5.1f %6.0f | %8.3f %7.3f %6.2f %9.5f %6.2f %9.3f %8.3f %6d | %8.1f%%\n",
                    size_known ? "known" : "free", disc_px, times, 100.0 * cell.bias,
                    100.0 * cell.rmse, cell.rmse / bound.flux, cell.centre_px,
                    cell.centre_px / bound.centre_px, cell.coverage, cell.flagged, cell.found,
                    100.0 * cell.aperture);
        EXPECT_EQ(cell.found, kSaturatedTrials);
        const double four_sigma = 4.0 * cell.rmse / std::sqrt(kSaturatedTrials);
        EXPECT_LT(std::abs(cell.bias), 0.005 + four_sigma);
        EXPECT_LT(cell.rmse, (size_known ? 0.01 : 0.02) * (1.0 + 4.0 * 0.035));
        EXPECT_LT(cell.centre_px, 0.005 * (1.0 + 4.0 * 0.025));
        EXPECT_NEAR(cell.coverage, 0.95, 0.02 + 4.0 * 0.011);
        EXPECT_LT(cell.flagged, 0.05);
        if (times == 5.0) first_ln = std::log1p(cell.bias);
        last_ln = std::log1p(cell.bias);
      }
      EXPECT_NEAR(1.0 + (last_ln - first_ln) / std::log(2000.0 / 5.0), 1.0, 0.01);
    }
}

// A wing share that is wrong by a fifth is another flux, and no picture whose core clips can tell:
// the calibration's sigma has to say so. Another shape of the wings can be seen.
TEST_F(LampFitStudy, WingsWrongByAFifthAreFlaggedWhereTheyCanBe) {
  const PsfShape glare{0.9, 0.03, 2.0, 2.5};
  LampPictures pictures(glare, 81);
  for (const bool of_share : {false, true})
    for (const double factor : {0.85, 1.2}) {
      PsfShape wrong = glare;
      (of_share ? wrong.wing_share : wrong.wing_exponent) *= factor;
      LampFitter fitter(wrong);
      for (const double disc_px : {0.5, 3.0, 6.0})
        for (const double times : {20.0, 100.0, 500.0, 2000.0}) {
          const SaturatedCell cell = measured(pictures, fitter, disc_px, times, false, 100);
          std::printf("%s x %.2f, disc %.1f px, %5.0f x white: flagged %.3f, flux off by %.2f %%\n",
                      of_share ? "wing share" : "wing exponent", factor, disc_px, times,
                      cell.flagged, 100.0 * cell.bias);
          if (!of_share) {
            EXPECT_GE(cell.flagged, 0.95);
          }
        }
    }
}

}  // namespace
}  // namespace vildar
