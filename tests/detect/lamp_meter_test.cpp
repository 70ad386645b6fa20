#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/quantity.h"
#include "detect/detector.h"
#include "detect/lamp_meter.h"
#include "detect/lamp_pictures.h"
#include "scene.h"

namespace vildar {
namespace {

constexpr int kSide_px = 121;

Frame frame_of(const std::vector<double>& light, std::uint64_t seed) {
  scene::Picture picture(kSide_px, kSide_px, 0.01);
  Random random(seed);
  for (int v = 0; v < kSide_px; ++v)
    for (int u = 0; u < kSide_px; ++u) {
      double& here = picture.at(u, v);
      here += light[static_cast<std::size_t>(v * kSide_px + u)];
      here += random.normal(0.0, std::sqrt(here / DetectOptions{}.full_well_electrons));
    }
  return picture.frame8(0.6, seed + 1000);
}

TEST(LampMeter, MeasuresThePairOfAVehicleWhereItsPixelsClip) {
  LampPictures pictures(kGlare, kSide_px);
  Detector detector(DetectOptions{}, Response(), std::nullopt, PsfSite{kGlare, 0.0});
  Detector without(DetectOptions{}, Response(), std::nullopt);
  constexpr int kTrials = 12;
  const double flux = pictures.flux(2.0, 60.0);
  int seen = 0, fitted = 0;
  double error = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Eigen::Vector2d left(45.3 + 0.7 * trial, 60.2 + 0.1 * trial);
    const Eigen::Vector2d right = left + Eigen::Vector2d(21.4, 0.3);
    const Frame frame =
        frame_of(pictures.of({LampPictures::lamp(left.x(), left.y(), 2.0, flux),
                              LampPictures::lamp(right.x(), right.y(), 2.0, 0.8 * flux)}),
                 static_cast<std::uint64_t>(50 + trial));
    const BlobFrame found = detector.detect(frame);
    for (const Blob& blob : found.blobs) {
      if (blob.saturated_px == 0) continue;  // a speck of glare
      ++seen;
      const bool is_left = blob.centre_px.x() < 0.5 * (left + right).x();
      const double truth = (is_left ? 1.0 : 0.8) * flux;
      EXPECT_LT((blob.centre_px - (is_left ? left : right)).norm(), 0.1);
      if (!blob.lamp) continue;
      ++fitted;
      error += blob.lamp->flux / truth - 1.0;
      EXPECT_NEAR(blob.lamp->flux, truth, 5.0 * blob.lamp->flux_sigma);
      EXPECT_LT(blob.lamp->flux_sigma, 0.05 * truth);
      EXPECT_NEAR(blob.lamp->radius_px, 2.0, 0.2);
    }
    for (const Blob& blob : without.detect(frame).blobs) {
      if (blob.saturated_px == 0) continue;
      EXPECT_FALSE(blob.lamp);
      EXPECT_LT(blob.flux, 0.5 * flux);
      EXPECT_GE(blob.flux_sigma, blob.flux);
    }
  }
  EXPECT_EQ(seen, 2 * kTrials);
  EXPECT_GE(fitted, 2 * kTrials * 8 / 10);
  EXPECT_LT(std::abs(error / fitted), 0.01);
}

/// As a coder leaves it: edges softer, errors by patches of pixels, holes in what clips.
Frame coded(const Frame& frame, std::uint64_t seed, double patch_error_codes = 4.0) {
  constexpr double kSide = 0.08;
  auto codes = std::make_shared<std::vector<std::uint8_t>>();
  Random random(seed);
  std::vector<double> errors(static_cast<std::size_t>(kSide_px * kSide_px));
  for (double& error : errors) error = random.normal(0.0, patch_error_codes);
  const auto code = [&](int u, int v) {
    return static_cast<double>(
        frame.luma.code(std::clamp(u, 0, kSide_px - 1), std::clamp(v, 0, kSide_px - 1)));
  };
  for (int v = 0; v < kSide_px; ++v)
    for (int u = 0; u < kSide_px; ++u) {
      const double beside = code(u - 1, v) + code(u + 1, v) + code(u, v - 1) + code(u, v + 1);
      const double here = (1.0 - 4.0 * kSide) * code(u, v) + kSide * beside +
                          errors[static_cast<std::size_t>(v / 2 * kSide_px + u / 2)];
      codes->push_back(static_cast<std::uint8_t>(
          std::lround(std::clamp(here, 0.0, static_cast<double>(frame.luma.white_code)))));
    }
  Frame out = frame;
  out.luma.data = codes->data();
  out.luma.stride_bytes = kSide_px;
  out.luma.owner = codes;
  return out;
}

TEST(LampMeter, KnowsLampsOfCodedPicturesLessWell) {
  LampPictures pictures(kGlare, kSide_px);
  DetectOptions lossy;
  lossy.lossy = true;
  constexpr int kTrials = 20;
  const double flux = pictures.flux(2.0, 60.0);
  int fitted = 0, inside = 0, taken_for_lossless = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Eigen::Vector2d at(60.3 + 0.1 * trial, 60.2);
    const Frame frame = coded(frame_of(pictures.of({LampPictures::lamp(at.x(), at.y(), 2.0, flux)}),
                                       static_cast<std::uint64_t>(80 + trial)),
                              static_cast<std::uint64_t>(trial));
    for (const bool told : {true, false}) {
      Detector detector(told ? lossy : DetectOptions{}, Response(), std::nullopt,
                        PsfSite{kGlare, 0.0});
      for (const Blob& blob : detector.detect(frame).blobs) {
        if (blob.saturated_px < 10) continue;
        EXPECT_LT((blob.centre_px - at).norm(), 0.25);
        if (!told) {
          taken_for_lossless +=
              blob.lamp && std::abs(blob.lamp->flux - flux) < 2.0 * blob.lamp->flux_sigma;
          continue;
        }
        if (!blob.lamp) continue;
        ++fitted;
        EXPECT_TRUE(blob.lamp->coded);
        EXPECT_GE(blob.lamp->flux_sigma, 0.05 * blob.lamp->flux);
        EXPECT_GE(blob.centre_sigma_px.minCoeff(), 0.05);
        inside += std::abs(blob.lamp->flux - flux) < 2.0 * blob.lamp->flux_sigma;
      }
    }
  }
  EXPECT_GE(fitted, 0.6 * kTrials);
  EXPECT_GE(inside, 0.8 * fitted);
  EXPECT_LT(taken_for_lossless, inside);
}

// What coding does to rims passes for another radius and light; it moves no lamp.
TEST(LampMeter, TellsTheLightOfCodedPicturesWhereRimsCountLittle) {
  LampPictures pictures(kGlare, kSide_px);
  DetectOptions lossy;
  lossy.lossy = true;
  constexpr int kTrials = 20;
  constexpr double kSlight_codes = 2.0;
  double error_ln = 0.0, away_px = 0.0;
  int fitted = 0;
  struct Case {
    double radius_px, times_white;
  };
  for (const auto& [radius_px, times_white] :
       {Case{1.5, 30.0}, Case{3.0, 15.0}, Case{3.0, 150.0}}) {
    const double flux = pictures.flux(radius_px, times_white);
    for (int trial = 0; trial < kTrials; ++trial) {
      const Eigen::Vector2d at(60.3 + 0.1 * trial, 60.2);
      const LampImage lamp = LampPictures::lamp(at.x(), at.y(), radius_px, flux);
      const Frame frame =
          coded(frame_of(pictures.of({lamp}), static_cast<std::uint64_t>(280 + trial)),
                static_cast<std::uint64_t>(trial), kSlight_codes);
      Detector detector(lossy, Response(), std::nullopt, PsfSite{kGlare, 0.0});
      for (const Blob& blob : detector.detect(frame).blobs) {
        if (blob.saturated_px < 4 || !blob.lamp) continue;
        ++fitted;
        error_ln += std::log(blob.lamp->flux / flux);
        away_px += (blob.centre_px - at).norm();
      }
    }
  }
  EXPECT_GE(fitted, 0.7 * 3 * kTrials);
  EXPECT_LT(std::abs(error_ln / fitted), 0.05);  // 0.066 where rims count as all pixels do
  EXPECT_LT(away_px / fitted, 0.03);
}

// In a picture coded badly a far lamp's radius is hardly told by one picture, and its light with
// it.
TEST(LampMeter, KeepsLightOfCodedPicturesThatARadiusWouldTell) {
  LampPictures pictures(kGlare, kSide_px);
  DetectOptions lossy;
  lossy.lossy = true;
  constexpr int kTrials = 20;
  constexpr double kMost = 0.3, kRadius_px = 0.8, kBadly_codes = 8.0;
  const double flux = pictures.flux(kRadius_px, 12.0);
  int untold = 0, inside = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Frame frame = coded(
        frame_of(pictures.of({LampPictures::lamp(60.3, 60.0 + 0.05 * trial, kRadius_px, flux)}),
                 static_cast<std::uint64_t>(180 + trial)),
        static_cast<std::uint64_t>(trial), kBadly_codes);
    Detector detector(lossy, Response(), std::nullopt, PsfSite{kGlare, 0.0});
    for (const Blob& blob : detector.detect(frame).blobs) {
      if (blob.saturated_px < 4 || !blob.lamp) continue;
      EXPECT_LT(blob.lamp->log_flux_sigma_at_radius, kMost);
      if (blob.lamp->told()) continue;
      ++untold;
      EXPECT_GE(blob.lamp->flux_sigma, kMost * blob.lamp->flux);
      EXPECT_EQ(light_of(blob).flux, blob.flux);
      const double at_radius_ln =
          std::log(blob.lamp->flux / flux) +
          blob.lamp->log_flux_per_radius * (kRadius_px - blob.lamp->radius_px);
      inside += std::abs(at_radius_ln) < kMost;
    }
  }
  EXPECT_GE(untold, kTrials / 4);
  EXPECT_GE(inside, 0.8 * untold);
}

// A lamp that is new may turn out to shine otherwise than its rim said: its neighbours are fitted
// again, but none that its light does not reach.
TEST(LampMeter, LampsFarOffChangeNothing) {
  LampPictures pictures(kGlare, kSide_px);
  const double flux = pictures.flux(2.0, 60.0);
  Detector detector(DetectOptions{}, Response(), std::nullopt);
  const Frame frame = frame_of(pictures.of({LampPictures::lamp(20.3, 60.2, 2.0, flux),
                                            LampPictures::lamp(101.4, 60.1, 2.0, 0.5 * flux)}),
                               7);
  const std::optional<SeenLights> seen = detector.look(frame);
  ASSERT_TRUE(seen);
  std::vector<Peak> peaks;
  std::vector<Measured> both;
  for (const double u_px : {20.3, 101.4})
    for (std::size_t i = 0; i < seen->peaks.size(); ++i)
      if (std::abs(seen->lights[i].centre_px.x() - u_px) < 1.0 && seen->peaks[i].clipped_px > 0) {
        peaks.push_back(seen->peaks[i]);
        both.push_back(seen->lights[i]);
      }
  ASSERT_EQ(both.size(), 2u);
  std::vector<Measured> alone(both.begin(), both.begin() + 1);
  LampMeter first(PsfSite{kGlare, 0.0}, std::nullopt), second = first;
  for (LampMeter* meter : {&first, &second}) {
    std::vector<Measured> before = alone;
    meter->measure(seen->light, nullptr, frame.time, {peaks[0]}, before);
  }
  const CameraTime next = frame.time + std::chrono::milliseconds(40);
  first.measure(seen->light, nullptr, next, {peaks[0]}, alone);
  second.measure(seen->light, nullptr, next, peaks, both);
  ASSERT_TRUE(alone[0].lamp && both[0].lamp && both[1].lamp);
  EXPECT_EQ(both[0].lamp->flux, alone[0].lamp->flux);
  EXPECT_EQ(both[0].centre_px, alone[0].centre_px);
}

TEST(LampMeter, WhatIsNoDiscIsMarkedAndKeepsItsPlainMeasures) {
  // A bar of light, as a lit sign: no lamp has this picture.
  std::vector<double> light(static_cast<std::size_t>(kSide_px * kSide_px), 0.0);
  for (int v = 56; v < 65; ++v)
    for (int u = 50; u < 64; ++u) light[static_cast<std::size_t>(v * kSide_px + u)] = 0.6;
  Detector detector(DetectOptions{}, Response(), std::nullopt, PsfSite{kGlare, 0.0});
  const BlobFrame found = detector.detect(frame_of(light, 7));
  ASSERT_EQ(found.blobs.size(), 1U);
  EXPECT_FALSE(found.blobs[0].lamp);
  EXPECT_TRUE(has(found.blobs[0].defects, Defect::bad_fit));
  EXPECT_NEAR(found.blobs[0].centre_px.x(), 56.5, 0.3);
}

}  // namespace
}  // namespace vildar
