#include "optics/disc_image.h"

#include <cmath>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "core/quantity.h"

namespace vildar {
namespace {

double point_spread(const PsfShape& shape, double r2) {
  const double s2 = shape.core_sigma_px * shape.core_sigma_px;
  const double a2 = shape.wing_scale_px * shape.wing_scale_px;
  return (1.0 - shape.wing_share) * std::exp(-0.5 * r2 / s2) / (2.0 * kPi * s2) +
         shape.wing_share * (0.5 * shape.wing_exponent - 1.0) / (kPi * a2) *
             std::pow(1.0 + r2 / a2, -0.5 * shape.wing_exponent);
}

/// The PSF over every pair of a point of the pixel (Gauss and Legendre on its quarters) and a point
/// of the disc (midpoints of rings and angles).
double brute_force(const PsfShape& shape, double disc_px, double du_px, double dv_px) {
  static constexpr double kNode = 0.19364916731037085;  // sqrt(3/5) / 4
  static constexpr double kPlaces[6] = {-0.25 - kNode, -0.25, -0.25 + kNode,
                                        0.25 - kNode,  0.25,  0.25 + kNode};
  static constexpr double kWeights[6] = {5.0 / 36, 8.0 / 36, 5.0 / 36,
                                         5.0 / 36, 8.0 / 36, 5.0 / 36};
  constexpr int kRings = 80, kAngles = 64;
  double sum = 0.0;
  for (int i = 0; i < 36; ++i) {
    const double u = du_px + kPlaces[i % 6], v = dv_px + kPlaces[i / 6];
    for (int k = 0; k < kRings; ++k) {
      const double s_px = disc_px * (k + 0.5) / kRings;
      const double weight = kWeights[i % 6] * kWeights[i / 6] * (2.0 * k + 1.0) / kRings / kRings;
      for (int j = 0; j < kAngles; ++j) {
        const double angle_rad = 2.0 * kPi * (j + 0.5) / kAngles;
        const double x = u - s_px * std::cos(angle_rad), y = v - s_px * std::sin(angle_rad);
        sum += weight * point_spread(shape, x * x + y * y) / kAngles;
      }
    }
  }
  return sum;
}

TEST(DiscImage, IsThePsfOverDiscAndPixel) {
  constexpr double kOfPeak = 4e-4;  // the table's cubics; the brute force is finer
  for (const PsfShape& shape : {PsfShape{0.9, 0.03, 2.0, 2.5}, PsfShape{0.6, 0.1, 1.0, 3.0}}) {
    DiscImage image(shape);
    for (const double disc_px : {0.0, 0.3, 1.37, 4.0}) {
      image.set_radius(disc_px);
      const double peak = brute_force(shape, disc_px, 0.0, 0.0);
      for (const auto& [du, dv] : {std::pair{0.0, 0.0},
                                   {0.4, 0.1},
                                   {-0.7, 0.7},
                                   {1.0, -2.2},
                                   {3.0, 2.4},
                                   {4.1, 0.0},
                                   {-3.0, -3.0},
                                   {7.0, 1.0}})
        EXPECT_NEAR(image.at(du, dv).share, brute_force(shape, disc_px, du, dv), kOfPeak * peak)
            << "disc " << disc_px << " at " << du << ", " << dv;
    }
  }
}

TEST(DiscImage, FarOutTheWingOfALargeDiscIsThatOfAPointOfItsFlux) {
  constexpr double kRelative = 5e-3;  // (disc / distance)^2 times q^2 / 8, and the table's steps
  const PsfShape shape{0.9, 0.05, 2.0, 2.5};
  DiscImage image(shape);
  image.set_radius(8.0);
  for (const double r_px : {120.0, 250.0})
    EXPECT_NEAR(image.at(r_px, 0.0).share / point_spread(shape, r_px * r_px), 1.0, kRelative);
}

TEST(DiscImage, PixelsOfAPictureAddUpToTheFlux) {
  const PsfShape shape{0.7, 0.0, 2.0, 2.5};
  DiscImage image(shape);
  for (const double disc_px : {0.0, 2.6, 11.0}) {
    image.set_radius(disc_px);
    double sum = 0.0;
    for (int v = -24; v <= 24; ++v)
      for (int u = -24; u <= 24; ++u) sum += image.at(u - 0.3, v + 0.2).share;
    EXPECT_NEAR(sum, 1.0, 2e-4) << "disc " << disc_px;
  }
}

TEST(DiscImage, DerivativesAreThoseOfTheShare) {
  constexpr double kStep = 1e-4;
  constexpr double kOfPeak = 4e-3;  // slopes of a piecewise cubic
  PsfShape shape{0.9, 0.04, 2.0, 2.5};
  PsfShape more = shape;
  more.wing_share += kStep;
  DiscImage image(shape), other(shape), winged(more);
  for (const double disc_px : {0.4, 2.9, 7.3}) {
    image.set_radius(disc_px);
    other.set_radius(disc_px + kStep);
    winged.set_radius(disc_px);
    const double peak = image.at(0.0, 0.0).share;
    for (const auto& [du, dv] :
         {std::pair{0.2, 0.1}, {1.3, -0.8}, {-2.4, 1.5}, {5.0, 5.2}, {0.0, 7.7}, {-19.0, 3.0}}) {
      const DiscImage::Pixel here = image.at(du, dv);
      EXPECT_NEAR(here.per_u, (image.at(du - kStep, dv).share - here.share) / kStep,
                  kOfPeak * peak);
      EXPECT_NEAR(here.per_v, (image.at(du, dv - kStep).share - here.share) / kStep,
                  kOfPeak * peak);
      EXPECT_NEAR(here.per_radius, (other.at(du, dv).share - here.share) / kStep, kOfPeak * peak);
      EXPECT_NEAR(here.per_wing_share, (winged.at(du, dv).share - here.share) / kStep,
                  kOfPeak * peak);
    }
  }
}

TEST(DiscImage, ManyPixelsTogetherAreThoseOfEachAlone) {
  constexpr double kOfPeak = 2e-5;  // single precision, over nodes a sixth of a sigma apart
  const PsfShape shape{0.9, 0.04, 2.0, 2.5};
  DiscImage image(shape);
  const Eigen::Vector2d centre_px(0.37, -0.22);
  std::vector<float> u_px, v_px;
  for (int v = -20; v < 28; ++v)
    for (int u = -20; u < 28; ++u) {
      u_px.push_back(static_cast<float>(u));
      v_px.push_back(static_cast<float>(v));
    }
  for (const double disc_px : {0.0, 0.4, 5.3}) {
    image.set_radius(disc_px);
    DiscImage::Pixels pixels;
    pixels.share.assign(7, 1.0F);
    image.set_to(pixels, u_px, v_px, centre_px, 0.25);
    image.add_to(pixels, u_px, v_px, centre_px, 0.75);
    std::vector<float> share(u_px.size(), 0.0F);
    for (const double weight : {0.25, 0.75}) image.add_to(share, u_px, v_px, centre_px, weight);
    const double near = kOfPeak * image.at(0.0, 0.0).share;
    for (std::size_t i = 0; i < u_px.size(); ++i) {
      const DiscImage::Pixel one = image.at(static_cast<double>(u_px[i]) - centre_px.x(),
                                            static_cast<double>(v_px[i]) - centre_px.y());
      ASSERT_NEAR(pixels.share[i], one.share, near) << disc_px << " " << i;
      ASSERT_NEAR(share[i], one.share, near) << disc_px << " " << i;
      ASSERT_NEAR(pixels.per_u[i], one.per_u, near) << disc_px << " " << i;
      ASSERT_NEAR(pixels.per_v[i], one.per_v, near) << disc_px << " " << i;
      ASSERT_NEAR(pixels.per_radius[i], one.per_radius, near) << disc_px << " " << i;
      ASSERT_NEAR(pixels.per_wing_share[i], one.per_wing_share, near / shape.wing_share)
          << disc_px << " " << i;
    }
  }
}

TEST(DiscImage, RefusesWhatIsNoPsfAndNoDisc) {
  EXPECT_THROW(DiscImage({0.3, 0.0, 2.0, 2.5}), std::invalid_argument);
  EXPECT_THROW(DiscImage({0.9, 1.0, 2.0, 2.5}), std::invalid_argument);
  EXPECT_THROW(DiscImage({0.9, 0.1, 2.0, 2.0}), std::invalid_argument);
  DiscImage image(PsfShape{});
  EXPECT_THROW(image.set_radius(-0.1), std::domain_error);
  EXPECT_THROW(image.set_radius(61.0), std::domain_error);
  std::vector<float> sum(16, 0.0F), u_px(16, 0.0F), v_px(15, 0.0F);
  EXPECT_THROW(image.add_to(sum, u_px, v_px, {0.0, 0.0}, 1.0), std::invalid_argument);
  EXPECT_THROW(image.add_to(v_px, v_px, v_px, {0.0, 0.0}, 1.0), std::invalid_argument);
}

}  // namespace
}  // namespace vildar
