#include "detect/detector.h"

#include <gtest/gtest.h>

#include <array>
#include <stdexcept>

#include "scene.h"

namespace vildar {
namespace {

using scene::Picture;

BlobFrame detected(const Frame& frame, std::optional<double> exposure_s = std::nullopt) {
  return Detector(DetectOptions{}, Response(), exposure_s).detect(frame);
}

/// The blob nearest to a place.
const Blob& nearest(const BlobFrame& found, double u, double v) {
  const Eigen::Vector2d place(u, v);
  return *std::min_element(found.blobs.begin(), found.blobs.end(),
                           [&](const Blob& a, const Blob& b) {
                             return (a.centre_px - place).norm() < (b.centre_px - place).norm();
                           });
}

struct Coding {
  int bit_depth, black_code, white_code, clip_code;
};

class DetectorCoding : public testing::TestWithParam<Coding> {};

TEST_P(DetectorCoding, CentreFluxAndSpreadOfAGaussian) {
  const Coding coding = GetParam();
  for (const double spread_px : {0.9, 1.6, 3.0}) {
    const double flux = 0.5 * 2.0 * kPi * spread_px * spread_px;  // half of white at its peak
    Picture picture(80, 60, 0.01);
    picture.add_gaussian(33.3, 27.8, spread_px, flux);
    const BlobFrame found = detected(picture.frame(Response(), coding.bit_depth, coding.black_code,
                                                   coding.white_code, coding.clip_code));
    ASSERT_EQ(found.blobs.size(), 1u) << spread_px;
    const Blob& blob = found.blobs[0];
    EXPECT_LT(std::abs(blob.centre_px.x() - 33.3), 3.0 * blob.centre_sigma_px.x());
    EXPECT_LT(std::abs(blob.centre_px.y() - 27.8), 3.0 * blob.centre_sigma_px.y());
    EXPECT_LT(blob.centre_sigma_px.maxCoeff(), 0.03);
    // The aperture of 3.5 spreads holds 99.8 % of the light; rounding of 8-bit codes does the rest.
    EXPECT_NEAR(blob.flux / flux, 1.0, 0.02) << spread_px;
    // A pixel's own width adds 1/12 to the variance.
    const double seen_px = std::sqrt(spread_px * spread_px + 1.0 / 12.0);
    EXPECT_NEAR(blob.spread_px.x() / seen_px, 1.0, 0.05);
    EXPECT_NEAR(blob.spread_px.y() / seen_px, 1.0, 0.05);
    EXPECT_EQ(blob.saturated_px, 0);
    EXPECT_EQ(blob.defects, Defect::none);
    EXPECT_EQ(blob.kind, LampKind::headlamp);
    EXPECT_NEAR(blob.row_fraction, (27.8 + 0.5) / 60.0 - 0.5, 1e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(Codings, DetectorCoding,
                         testing::Values(Coding{8, 0, 255, 255}, Coding{8, 16, 235, 255},
                                         Coding{10, 64, 940, 1023}, Coding{10, 0, 1023, 1023},
                                         Coding{16, 4096, 60160, 65535}));

TEST(Detector, SigmasAreHonest) {
  constexpr int kTrials = 250;
  // What lenses whose wings hold 3 and 6 % of the light spread beyond the aperture.
  constexpr std::array kWings{0.021, 0.043};
  constexpr double kWings_px = 12.0;
  // Of 2 * 250 normal values the rms has a standard error of 1 / sqrt(1000) = 3 %; the rest of the
  // room is for the noise model, which does not know that this noise is not light's own.
  for (const double spread_px : {1.0, 1.6, 2.5}) {
    for (const double peak : {0.15, 0.6}) {
      const double flux = peak * 2.0 * kPi * spread_px * spread_px;
      Random random(77);
      double centre_square = 0.0, flux_square = 0.0;
      for (int trial = 0; trial < kTrials; ++trial) {
        const double u = 20.0 + random.uniform(), v = 18.0 + random.uniform();
        Picture picture(42, 40, 0.02);
        const double wings = kWings[static_cast<std::size_t>(trial % 2)];
        picture.add_gaussian(u, v, spread_px, (1.0 - wings) * flux);
        picture.add_gaussian(u, v, kWings_px, wings * flux);
        const BlobFrame found = detected(picture.frame8(2.0, 1000 + trial));
        ASSERT_EQ(found.blobs.size(), 1u);
        const Blob& blob = found.blobs[0];
        const Eigen::Vector2d error = blob.centre_px - Eigen::Vector2d(u, v);
        centre_square += error.cwiseQuotient(blob.centre_sigma_px).squaredNorm();
        flux_square += std::pow((blob.flux - flux) / blob.flux_sigma, 2);
      }
      const double centre_rms = std::sqrt(centre_square / (2 * kTrials));
      const double flux_rms = std::sqrt(flux_square / kTrials);
      EXPECT_GT(centre_rms, 0.7) << "spread " << spread_px << ", peak " << peak;
      EXPECT_LT(centre_rms, 1.3) << "spread " << spread_px << ", peak " << peak;
      EXPECT_GT(flux_rms, 0.6) << "spread " << spread_px << ", peak " << peak;
      EXPECT_LT(flux_rms, 1.5) << "spread " << spread_px << ", peak " << peak;
    }
  }
}

/// Errors of 1.8 % of white that each patch of 3 x 2 pixels shares.
Frame with_shared_errors(Frame frame, std::uint64_t seed) {
  constexpr double kSigma_codes = 0.018 * 255.0;
  const LumaView before = frame.luma;
  auto plane = std::make_shared<std::vector<std::uint8_t>>();
  Random random(seed);
  std::vector<double> errors(static_cast<std::size_t>(before.width_px));
  for (int v = 0; v < before.height_px; ++v)
    for (int u = 0; u < before.width_px; ++u) {
      double& error = errors[static_cast<std::size_t>(u / 3)];
      if (v % 2 == 0 && u % 3 == 0) error = random.normal(0.0, kSigma_codes);
      plane->push_back(static_cast<std::uint8_t>(
          std::lround(std::clamp(before.code(u, v) + error, 0.0, 255.0))));
    }
  frame.luma.data = plane->data();
  frame.luma.stride_bytes = before.width_px;
  frame.luma.owner = std::move(plane);
  return frame;
}

TEST(Detector, SigmasKnowWhatCodingWithLossDoes) {
  constexpr int kTrials = 250;
  DetectOptions lossy;
  lossy.lossy = true;
  // Errors alike over 3 x 2 pixels err less together than six do in a light as small as this, and
  // none is too small for its sigma by more than the 3 % that 500 values leave open.
  for (const double spread_px : {1.0, 1.6, 2.5}) {
    Random random(78);
    const double flux = 0.6 * 2.0 * kPi * spread_px * spread_px;
    double centre_square = 0.0, flux_square = 0.0;
    for (int trial = 0; trial < kTrials; ++trial) {
      const double u = 20.0 + 3.0 * random.uniform(), v = 18.0 + 2.0 * random.uniform();
      Picture picture(42, 40, 0.02);
      picture.add_gaussian(u, v, spread_px, flux);
      const Frame frame = with_shared_errors(picture.frame8(), 1000 + trial);
      const BlobFrame found = Detector(lossy, Response(), std::nullopt).detect(frame);
      ASSERT_FALSE(found.blobs.empty());
      const Blob& blob = nearest(found, u, v);
      const Eigen::Vector2d error = blob.centre_px - Eigen::Vector2d(u, v);
      centre_square += error.cwiseQuotient(blob.centre_sigma_px).squaredNorm();
      flux_square += std::pow((blob.flux - flux) / blob.flux_sigma, 2);
    }
    const double centre_rms = std::sqrt(centre_square / (2 * kTrials));
    const double flux_rms = std::sqrt(flux_square / kTrials);
    EXPECT_GT(centre_rms, 0.3) << "spread " << spread_px;
    EXPECT_LT(centre_rms, 1.06) << "spread " << spread_px;
    EXPECT_GT(flux_rms, 0.3) << "spread " << spread_px;
    EXPECT_LT(flux_rms, 1.06) << "spread " << spread_px;
  }
}

/// Each code with a share of how far its four neighbours lie from it: a variance of twice that.
Frame softened(Frame frame, double share) {
  const LumaView before = frame.luma;
  auto plane = std::make_shared<std::vector<std::uint8_t>>();
  const auto code = [&](int u, int v) {
    return before.code(std::clamp(u, 0, before.width_px - 1),
                       std::clamp(v, 0, before.height_px - 1));
  };
  for (int v = 0; v < before.height_px; ++v)
    for (int u = 0; u < before.width_px; ++u) {
      const int around =
          code(u - 1, v) + code(u + 1, v) + code(u, v - 1) + code(u, v + 1) - 4 * code(u, v);
      plane->push_back(static_cast<std::uint8_t>(std::lround(code(u, v) + share * around)));
    }
  frame.luma.data = plane->data();
  frame.luma.stride_bytes = before.width_px;
  frame.luma.owner = std::move(plane);
  return frame;
}

TEST(Detector, LampsThatCodingSoftenedKeepTheirFlux) {
  // Left as they are, softened codes cost 3 % of the light. Noise of two codes is 1.5 % of a light,
  // of the mean of 40 a quarter of a percent.
  constexpr double kVariance_px2 = 0.08, kFlux = 2.0, kShare = 0.01;
  constexpr int kTrials = 40;
  DetectOptions lossy;
  lossy.lossy = true;
  Random random(79);
  double sum = 0.0;
  int told = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    Picture picture(42, 40, 0.02);
    picture.add_gaussian(20.0 + random.uniform(), 19.0 + random.uniform(), 1.0, kFlux);
    const Frame frame = softened(picture.frame8(2.0, 2000 + trial), 0.5 * kVariance_px2);
    Detector detector(lossy, Response(), std::nullopt, PsfSite{{0.9, 0.0, 2.0, 2.5}, 0.0});
    for (const Blob& blob : detector.detect(frame).blobs) {
      if (!blob.lamp) continue;
      sum += blob.lamp->flux;
      ++told;
    }
  }
  ASSERT_GT(told, kTrials / 2);
  EXPECT_NEAR(sum / told, kFlux, kShare * kFlux);
}

TEST(Detector, ClippedDiscsKeepTheirCentre) {
  constexpr int kTrials = 20;
  // 1 + 3 standard errors of the rms of 2 * 20 values; errors far smaller than stated are no fault
  // here.
  constexpr double kMostRms = 1.34;
  Random random(5);
  for (const double radius_px : {1.5, 3.0, 8.0, 14.0}) {
    double square = 0.0;
    for (int trial = 0; trial < kTrials; ++trial) {
      const double u = 50.0 + random.uniform(), v = 45.0 + random.uniform();
      Picture picture(100, 90, 0.001);
      picture.add_disc(u, v, radius_px, 40.0);
      const double glare_px = radius_px + 3.0;
      picture.add_gaussian(u, v, glare_px, 0.2 * 2.0 * kPi * glare_px * glare_px);
      const Frame frame = picture.frame8(1.0, 50 + trial);
      const BlobFrame found = detected(frame);
      ASSERT_EQ(found.blobs.size(), 1u) << radius_px;
      const Blob& blob = found.blobs[0];
      int clipped = 0;
      for (int y = 0; y < 90; ++y)
        for (int x = 0; x < 100; ++x) clipped += frame.luma.code(x, y) >= 250;
      EXPECT_EQ(blob.saturated_px, clipped);
      EXPECT_EQ(blob.defects, Defect::saturated);
      const Eigen::Vector2d error = blob.centre_px - Eigen::Vector2d(u, v);
      square += error.cwiseQuotient(blob.centre_sigma_px).squaredNorm();
      EXPECT_GE(blob.centre_sigma_px.minCoeff(), 0.05);
      EXPECT_LT(blob.centre_sigma_px.maxCoeff(), 0.2);
      EXPECT_LT(blob.flux, 40.0 * kPi * radius_px * radius_px);  // a lower bound
      EXPECT_EQ(blob.kind, LampKind::headlamp);
      EXPECT_NEAR(blob.box.u_max - blob.box.u_min + 1, 2.0 * radius_px, 2.5);
    }
    EXPECT_LT(std::sqrt(square / (2 * kTrials)), kMostRms) << radius_px;
  }
}

TEST(Detector, LearnsTheCodeAtWhichTheCameraClips) {
  // Limited range: 245 is above nominal white, and no clipped code where the camera goes on to 255.
  Picture picture(200, 60, 0.001);
  picture.add_disc(40.0, 30.0, 8.0, 50.0);
  picture.add_disc(90.0, 30.0, 4.0, Response().linear_from_fraction((245.0 - 16.0) / 219.0));
  const BlobFrame wide = detected(picture.frame(Response(), 8, 16, 235, 255));
  ASSERT_EQ(wide.blobs.size(), 2u);
  EXPECT_GT(nearest(wide, 40.0, 30.0).saturated_px, 150);
  EXPECT_EQ(nearest(wide, 90.0, 30.0).saturated_px, 0);
  // The same scene from a camera that clips at nominal white.
  const BlobFrame narrow = detected(picture.frame(Response(), 8, 16, 235, 235));
  ASSERT_EQ(narrow.blobs.size(), 2u);
  EXPECT_GT(nearest(narrow, 90.0, 30.0).saturated_px, 30);
}

TEST(Detector, LampsJoinedByGlareOrBlooming) {
  struct Case {
    double radius_px, apart_px;
  };
  for (const Case& pair : {Case{3.0, 9.0}, Case{3.0, 7.0}, Case{8.0, 15.0}, Case{12.0, 20.0}}) {
    Picture picture(140, 80, 0.002);
    const double u_left = 60.2, u_right = 60.2 + pair.apart_px, v = 40.4;
    for (const double u : {u_left, u_right}) {
      picture.add_disc(u, v, pair.radius_px, 30.0);
      picture.add_gaussian(u, v, 1.5 * pair.radius_px,
                           0.3 * 6.28 * 2.25 * pair.radius_px * pair.radius_px);
    }
    const BlobFrame found = detected(picture.frame8(1.0));
    SCOPED_TRACE(testing::Message() << pair.radius_px << " px, " << pair.apart_px << " apart");
    ASSERT_EQ(found.blobs.size(), 2u);
    for (const double u : {u_left, u_right}) {
      const Blob& blob = nearest(found, u, v);
      EXPECT_TRUE(has(blob.defects, Defect::saturated));
      EXPECT_LT(std::abs(blob.centre_px.x() - u), 3.0 * blob.centre_sigma_px.x());
      EXPECT_LT(std::abs(blob.centre_px.y() - v), 3.0 * blob.centre_sigma_px.y());
      EXPECT_LT(blob.centre_sigma_px.maxCoeff(), 0.5);
    }
  }
}

TEST(Detector, FaintPairPartsAsSoonAsThereIsAValley) {
  Picture picture(60, 40, 0.0005);
  picture.add_gaussian(28.0, 20.0, 1.0, 3.0);
  picture.add_gaussian(31.5, 20.0, 1.0, 3.0);
  const BlobFrame found = detected(picture.frame8(1.0));
  ASSERT_EQ(found.blobs.size(), 2u);
  EXPECT_NEAR(nearest(found, 28.0, 20.0).centre_px.x(), 28.0, 0.15);
  EXPECT_NEAR(nearest(found, 31.5, 20.0).centre_px.x(), 31.5, 0.15);
}

TEST(Detector, TwoLampsRunTogetherAreMarkedMerged) {
  Picture picture(100, 60, 0.002);
  picture.add_disc(46.0, 30.0, 8.0, 30.0);
  picture.add_disc(57.0, 30.0, 8.0, 30.0);
  const BlobFrame found = detected(picture.frame8(1.0));
  ASSERT_EQ(found.blobs.size(), 1u);
  EXPECT_TRUE(has(found.blobs[0].defects, Defect::merged));
}

TEST(Detector, EdgesAreMarked) {
  const std::array<Eigen::Vector2d, 4> places = {
      Eigen::Vector2d(0.5, 20.0), {58.6, 20.0}, {30.0, 0.2}, {30.0, 39.0}};
  for (const Eigen::Vector2d& place : places) {
    Picture picture(60, 40, 0.002);
    picture.add_gaussian(place.x(), place.y(), 2.0, 10.0);
    const BlobFrame found = detected(picture.frame8(1.0));
    ASSERT_EQ(found.blobs.size(), 1u) << place.transpose();
    EXPECT_TRUE(has(found.blobs[0].defects, Defect::cut_by_edge)) << place.transpose();
  }
}

TEST(Detector, RotationGivesUprightPlacesAndStoredRows) {
  Picture picture(90, 50, 0.002);
  picture.add_gaussian(20.25, 31.5, 2.0, 8.0);
  Frame frame = picture.frame8();
  // A point at (u, v) of a 90 x 50 plane turned clockwise lies at (49 - v, u), and so on.
  const std::array<Eigen::Vector2d, 4> places = {Eigen::Vector2d(20.25, 31.5),
                                                 {49.0 - 31.5, 20.25},
                                                 {89.0 - 20.25, 49.0 - 31.5},
                                                 {31.5, 89.0 - 20.25}};
  for (int quarter = 0; quarter < 4; ++quarter) {
    frame.rotation_deg = 90 * quarter;
    const BlobFrame found = detected(frame);
    ASSERT_EQ(found.blobs.size(), 1u);
    const Blob& blob = found.blobs[0];
    EXPECT_LT((blob.centre_px - places[quarter]).norm(), 0.03) << 90 * quarter;
    EXPECT_LE(blob.box.u_min, blob.centre_px.x());
    EXPECT_GE(blob.box.u_max, blob.centre_px.x());
    EXPECT_LE(blob.box.v_min, blob.centre_px.y());
    EXPECT_GE(blob.box.v_max, blob.centre_px.y());
    EXPECT_NEAR(blob.row_fraction, (31.5 + 0.5) / 50.0 - 0.5, 1e-3);
  }
  frame.rotation_deg = 45;
  EXPECT_THROW(detected(frame), std::invalid_argument);
}

TEST(Detector, RimColourTellsTailLampsFromHeadlamps) {
  struct Case {
    int cb, cr;
    LampKind kind;
  };
  // 8-bit chroma of white, bluish, yellowish and red light.
  for (const Case& colour :
       {Case{128, 128, LampKind::headlamp}, Case{150, 120, LampKind::headlamp},
        Case{108, 134, LampKind::headlamp}, Case{110, 170, LampKind::taillamp}}) {
    Picture picture(64, 48, 0.002);
    picture.add_disc(30.0, 22.0, 5.0, 20.0);
    picture.add_gaussian(30.0, 22.0, 5.0, 60.0);
    Frame frame = picture.frame8();
    std::vector<std::uint8_t> cb(32 * 24, 128), cr(32 * 24, 128);
    for (int v = 0; v < 24; ++v)
      for (int u = 0; u < 32; ++u) {
        const double away_px = std::hypot(2 * u + 0.5 - 30.0, 2 * v + 0.5 - 22.0);
        if (away_px < 4.0 || away_px > 12.0) continue;  // the clipped core has no colour
        cb[v * 32 + u] = static_cast<std::uint8_t>(colour.cb);
        cr[v * 32 + u] = static_cast<std::uint8_t>(colour.cr);
      }
    frame.chroma.cb = cb.data();
    frame.chroma.cr = cr.data();
    frame.chroma.stride_bytes = 32;
    const BlobFrame found = detected(frame);
    ASSERT_EQ(found.blobs.size(), 1u);
    EXPECT_EQ(found.blobs[0].kind, colour.kind) << colour.cb << ' ' << colour.cr;
    EXPECT_NEAR(found.blobs[0].cr, (colour.cr - 128) / 256.0,
                0.3 * std::abs(colour.cr - 128) / 256.0);
  }
}

TEST(Detector, LitSurfacesAreNotLamps) {
  Picture picture(320, 240, 0.01);
  picture.add_gaussian(90.0, 120.0, 20.0, 0.12 * 6.28 * 400.0);  // light on the road
  for (int v = 60; v < 180; ++v)
    for (int u = 200; u < 206; ++u) picture.at(u, v) += 0.2;  // a painted line
  picture.add_gaussian(260.0, 60.0, 1.5, 7.0);                // a lamp
  const BlobFrame found = detected(picture.frame8(2.0));
  ASSERT_GE(found.blobs.size(), 1u);
  int lamps = 0;
  for (const Blob& blob : found.blobs) lamps += blob.kind != LampKind::other;
  EXPECT_EQ(lamps, 1);
  EXPECT_EQ(nearest(found, 260.0, 60.0).kind, LampKind::headlamp);
}

TEST(Detector, NoiseAloneGivesNothing) {
  for (const double background : {0.0, 0.02, 0.2}) {
    const Picture picture(400, 300, background);
    EXPECT_TRUE(detected(picture.frame8(3.0)).blobs.empty()) << background;
  }
}

TEST(Detector, LampsStandOutOfALitScene) {
  // A street-lit scene: broad texture far brighter than a dark road, and two clipped lamps in it.
  Picture picture(320, 240, 0.0);
  for (int v = 0; v < 240; ++v)
    for (int u = 0; u < 320; ++u)
      picture.at(u, v) = 0.06 * (1.0 + std::sin(u * 0.06) * std::cos(v * 0.045));
  picture.add_disc(150.3, 100.6, 3.0, 20.0);
  picture.add_disc(162.1, 100.6, 3.0, 20.0);
  const BlobFrame found = detected(picture.frame(Response(), 8, 16, 235, 235, 2.0));
  int lamps = 0;
  for (const Blob& blob : found.blobs) lamps += blob.kind == LampKind::headlamp;
  EXPECT_EQ(lamps, 2);
  EXPECT_NEAR(nearest(found, 150.3, 100.6).centre_px.x(), 150.3, 0.15);
  EXPECT_NEAR(nearest(found, 162.1, 100.6).centre_px.x(), 162.1, 0.15);
}

TEST(Detector, ExposureDividesTheFlux) {
  Picture picture(60, 40, 0.002);
  picture.add_gaussian(30.0, 20.0, 2.0, 8.0);
  const Blob plain = detected(picture.frame8()).blobs.at(0);
  const Blob per_second = detected(picture.frame8(), 0.002).blobs.at(0);
  EXPECT_NEAR(per_second.flux / plain.flux, 500.0, 1e-9);
  EXPECT_NEAR(per_second.flux_sigma / plain.flux_sigma, 500.0, 1e-9);
}

TEST(Detector, DegenerateFrames) {
  EXPECT_TRUE(detected(Frame{}).blobs.empty());
  EXPECT_TRUE(detected(Picture(1, 1, 0.0).frame8()).blobs.empty());
  EXPECT_TRUE(detected(Picture(64, 48, 50.0).frame8()).blobs.empty()) << "as bright as its lights";
  EXPECT_TRUE(detected(Picture(1, 1, 50.0).frame8()).blobs.empty());
  Picture column(1, 40, 0.001);
  column.at(0, 20) = column.at(0, 21) = 0.9;
  EXPECT_EQ(detected(column.frame8()).blobs.size(), 1u);
  Frame frame = Picture(8, 8).frame8();
  frame.luma.bit_depth = 7;
  EXPECT_THROW(detected(frame), std::invalid_argument);
  frame.luma.bit_depth = 8;
  frame.luma.white_code = frame.luma.black_code;
  EXPECT_THROW(detected(frame), std::invalid_argument);
}

TEST(Detector, KeepsNothingOfAnEarlierFrame) {
  Picture first(100, 60, 0.002), second(64, 80, 0.002);
  first.add_gaussian(70.0, 30.0, 2.0, 8.0);
  first.add_gaussian(30.0, 30.0, 2.0, 8.0);
  second.add_gaussian(20.0, 60.0, 2.0, 8.0);
  const Frame wanted = second.frame(Response(), 10, 64, 940, 1023);
  Detector detector(DetectOptions{}, Response(), std::nullopt);
  detector.detect(first.frame8());
  const BlobFrame after = detector.detect(wanted), alone = detected(wanted);
  ASSERT_EQ(after.blobs.size(), alone.blobs.size());
  EXPECT_EQ(after.blobs[0].centre_px, alone.blobs[0].centre_px);
  EXPECT_EQ(after.blobs[0].flux, alone.blobs[0].flux);
}

TEST(Detector, RefusesBadOptions) {
  DetectOptions options;
  EXPECT_TRUE(options.problems().empty());
  options.threshold_sigma = 0.0;
  options.min_area_px = 0;
  options.max_bright_share = 1.5;
  EXPECT_EQ(options.problems().size(), 3u);
  EXPECT_THROW(Detector(options, Response(), std::nullopt), std::invalid_argument);
  EXPECT_THROW(Detector(DetectOptions{}, Response(), 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace vildar
