#include "calib/psf/calibrate_psf.h"

#include <gtest/gtest.h>

#include <cmath>

#include "lit_crops.h"

namespace vildar {
namespace {

TEST(CalibratePsf, FindsThePsfThatTookThePictures) {
  constexpr double kSigmas = 4.0;
  Random random(11);
  const PsfShape truth{1.2, 0.05, 1.6, 2.8};
  const auto crops = lit_crops(truth, 48, 0.3, 2000.0, random);
  const auto outcome = calibrate_psf(crops, false);
  ASSERT_TRUE(std::holds_alternative<PsfCalibration>(outcome)) << name_of(std::get<Miss>(outcome));
  const auto& found = std::get<PsfCalibration>(outcome);
  const PsfShape& shape = found.psf.shape;
  EXPECT_LT(std::abs(shape.core_sigma_px - truth.core_sigma_px), kSigmas * found.core_sigma_std_px);
  EXPECT_LT(std::abs(shape.wing_share - truth.wing_share), kSigmas * found.psf.wing_share_std);
  EXPECT_LT(std::abs(shape.wing_scale_px - truth.wing_scale_px), kSigmas * found.wing_scale_std_px);
  EXPECT_LT(std::abs(shape.wing_exponent - truth.wing_exponent), kSigmas * found.wing_exponent_std);
  EXPECT_LT(found.core_sigma_std_px, 0.02 * truth.core_sigma_px);
  EXPECT_LT(found.psf.wing_share_std, 0.1 * truth.wing_share);
  EXPECT_LT(found.chi2_per_dof, 1.1);
  EXPECT_GE(found.crops, 40);
}

// Passes through H.264 left cores 20 % off and shares by a factor of two, alike in all pictures.
TEST(CalibratePsf, IsDoubtedAfterCodingWithLoss) {
  Random random(11);
  const auto crops = lit_crops({1.2, 0.05, 1.6, 2.8}, 48, 0.3, 2000.0, random);
  const auto outcome = calibrate_psf(crops, true);
  ASSERT_TRUE(std::holds_alternative<PsfCalibration>(outcome)) << name_of(std::get<Miss>(outcome));
  const auto& found = std::get<PsfCalibration>(outcome);
  EXPECT_GT(found.core_sigma_std_px, 0.15 * found.psf.shape.core_sigma_px);
  EXPECT_GT(found.psf.wing_share_std, 0.5 * found.psf.shape.wing_share);
  EXPECT_LT(found.psf.wing_share_std, found.psf.shape.wing_share);
  EXPECT_EQ(found.undetermined, (std::vector<std::string>{"wing_scale_px", "wing_exponent"}));
}

TEST(CalibratePsf, NeedsEightCrops) {
  Random random(12);
  const auto outcome = calibrate_psf(lit_crops({}, 7, 0.5, 100.0, random), false);
  ASSERT_TRUE(std::holds_alternative<Miss>(outcome));
  EXPECT_EQ(std::get<Miss>(outcome), Miss::too_few_samples);
}

}  // namespace
}  // namespace vildar
