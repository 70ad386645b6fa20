// Single photographs of real roads, where the folder of reference data is there.

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "capture/clip_source.h"
#include "detect/detector.h"
#include "optics/response.h"
#include "support/shared_data.h"

namespace vildar {
namespace {

namespace fs = std::filesystem;

std::vector<Blob> headlamps_of(const fs::path& picture) {
  ClipSource source(picture, {});
  const auto frame = source.next();
  if (!frame) return {};
  Detector detector({}, Response(CameraSite{}), std::nullopt);
  std::vector<Blob> lights = detector.detect(*frame).blobs;
  std::erase_if(lights, [](const Blob& blob) { return blob.kind != LampKind::headlamp; });
  return lights;
}

std::vector<PixelBox> headlamp_boxes(const fs::path& annotation) {
  std::stringstream text;
  text << std::ifstream(annotation).rdbuf();
  static const std::regex object(
      "<name>headlight</name>[^]*?<xmin>(\\d+)</xmin>\\s*<ymin>(\\d+)</ymin>\\s*"
      "<xmax>(\\d+)</xmax>\\s*<ymax>(\\d+)</ymax>");
  std::vector<PixelBox> boxes;
  const std::string words = text.str();
  for (std::sregex_iterator found(words.begin(), words.end(), object), end; found != end; ++found)
    boxes.push_back({std::stoi((*found)[1]), std::stoi((*found)[2]), std::stoi((*found)[3]),
                     std::stoi((*found)[4])});
  return boxes;
}

// Boxes drawn by hand are off by a few pixels.
bool inside(const PixelBox& box, const Blob& blob) {
  constexpr double kMargin_px = 3.0;
  return blob.centre_px.x() > box.u_min - kMargin_px &&
         blob.centre_px.x() < box.u_max + kMargin_px &&
         blob.centre_px.y() > box.v_min - kMargin_px && blob.centre_px.y() < box.v_max + kMargin_px;
}

// Where a light without a box stands: the recorder writes text into its pictures, and the bonnet of
// its own car mirrors the lamps ahead.
enum Place { road, bonnet, text, places };
Place place_of(const Blob& blob) {
  constexpr double kBonnet_px = 870.0, kText_px = 1030.0;
  return blob.centre_px.y() > kText_px ? text : blob.centre_px.y() > kBonnet_px ? bonnet : road;
}

TEST(RealFrames, HeadlampsAtDuskAgainstBoxes) {
  const fs::path folder = shared_folder() / "data/frames/dashcam_dusk";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is absent";
  int frames = 0, boxes = 0, found = 0, in_box = 0;
  std::array<int, places> unmarked{};
  for (const auto& entry : fs::directory_iterator(folder / "annotations")) {
    ++frames;
    const std::string name = entry.path().stem().string();
    const std::vector<PixelBox> marked = headlamp_boxes(entry.path());
    const std::vector<Blob> lights = headlamps_of(folder / "images" / (name + ".jpg"));
    for (const PixelBox& box : marked) {
      ++boxes;
      const bool held = std::ranges::any_of(lights, [&](const Blob& b) { return inside(box, b); });
      found += held;
      if (!held)
        std::printf("%s: none in the box from (%d, %d) to (%d, %d)\n", name.c_str(), box.u_min,
                    box.v_min, box.u_max, box.v_max);
    }
    for (const Blob& blob : lights)
      if (std::ranges::any_of(marked, [&](const PixelBox& box) { return inside(box, blob); }))
        ++in_box;
      else
        ++unmarked[place_of(blob)];
  }
  std::printf(
      "%d frames: a headlamp in %d of %d boxes; %d headlamps in boxes, without one %d above "
      "the bonnet, %d on it, %d in the text\n",
      frames, found, boxes, in_box, unmarked[road], unmarked[bonnet], unmarked[text]);
  EXPECT_GE(found, 0.9 * boxes);
}

TEST(RealFrames, UnclippedPairOnARuralCurve) {
  const fs::path picture = shared_folder() / "data/frames/rural_curve_oncoming_pair.png";
  if (!fs::exists(picture)) GTEST_SKIP() << picture << " is absent";
  const std::vector<Blob> lights = headlamps_of(picture);
  constexpr double kReadByEye_px = 1.0;
  for (const Eigen::Vector2d& lamp_px : {Eigen::Vector2d(712, 489), Eigen::Vector2d(729, 489)}) {
    const auto blob = std::ranges::find_if(
        lights, [&](const Blob& one) { return (one.centre_px - lamp_px).norm() < kReadByEye_px; });
    ASSERT_NE(blob, lights.end()) << lamp_px.transpose();
    EXPECT_EQ(blob->saturated_px, 0);
    EXPECT_LT(blob->centre_sigma_px.maxCoeff(), 0.1);
    std::printf("(%.2f +- %.2f, %.2f +- %.2f) px, flux %.2f +- %.2f\n", blob->centre_px.x(),
                blob->centre_sigma_px.x(), blob->centre_px.y(), blob->centre_sigma_px.y(),
                blob->flux, blob->flux_sigma);
  }
}

}  // namespace
}  // namespace vildar
