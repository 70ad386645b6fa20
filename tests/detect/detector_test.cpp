#include "detect/detector.h"

#include <gtest/gtest.h>

#include "scene.h"

namespace vildar {
namespace {

using scene::Picture;

Detector detector() { return Detector(DetectOptions{}, Response(), std::nullopt); }

TEST(Detector, CentreAndFluxOfAGaussian) {
  Picture picture(80, 60, 0.002);
  picture.add_gaussian(33.3, 27.8, 1.6, 8.0);
  const BlobFrame found = detector().detect(picture.frame8());
  ASSERT_EQ(found.blobs.size(), 1u);
  const Blob& blob = found.blobs[0];
  EXPECT_NEAR(blob.centre_px.x(), 33.3, 0.01);
  EXPECT_NEAR(blob.centre_px.y(), 27.8, 0.01);
  EXPECT_NEAR(blob.flux, 8.0, 0.08);
  EXPECT_EQ(blob.saturated_px, 0);
}

}  // namespace
}  // namespace vildar
