extern "C" {
#include <libavutil/frame.h>
}

#include <algorithm>

#include "core/random.h"
#include "pipeline/broken.h"
#include "support/restamp.h"

namespace vildar {
namespace {

using test::ClipSpec;
using test::expect_told;
using test::Ran;

TEST_F(Broken, ClipThatIsNoneIsThree) {
  expect_told(run({path("missing.mp4").string(), "--site", site()}), 3,
              {"missing.mp4", "no such file", "check the name"});
  expect_told(run({write("empty.mp4", ""), "--site", site()}), 3,
              {"empty.mp4", "is empty", "copy it from the recorder again"});
  expect_told(run({write("text.mp4", "The lamps of a car at night.\n"), "--site", site()}), 3,
              {"text.mp4", "is not a video file", "check that it was copied whole"});
  expect_told(run({folder_.path().string(), "--site", site()}), 3,
              {"is a folder", "name the file inside it"});
  EXPECT_TRUE(test::files_in(out()).empty()) << "nothing is written";
}

TEST_F(Broken, ClipOfSoundAloneIsThree) {
  const std::string head(
      "RIFF\x24\x10\0\0WAVEfmt \x10\0\0\0\x01\0\x01\0\x40\x1f\0\0\x80\x3e\0\0"
      "\x02\0\x10\0data\0\x10\0\0",
      44);
  expect_told(run({write("sound.mp4", head + std::string(4096, '\x11')), "--site", site()}), 3,
              {"sound.mp4", "holds no video, only sound", "--photodiode"});
}

TEST_F(Broken, ClipCutInTheMiddleIsFourAndItsHalfIsUsed) {
  const std::string file = clip({.path = path("cut.mp4"),
                                 .encoder = "libx264",
                                 .frames = 100,
                                 .encoder_options = {{"qp", "0"}},
                                 .muxer_options = {{"movflags", "+faststart"}}});
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  expect_told(run({file, "--site", site()}), 4,
              {"cut.mp4", "ends early", "of 100 declared", "copy"});
  EXPECT_EQ(test::files_in(out()), kOutputs);
  EXPECT_NE(run_json().find("ends early"), std::string::npos);
}

TEST_F(Broken, ClipWithBitErrorsIsFourAndNamesTheFirstFrame) {
  std::string bytes = test::bytes_of(sample("straight") / "clip.mp4");
  Random random(3);
  for (int flip = 0; flip < 40; ++flip)
    bytes[static_cast<std::size_t>(random.uniform(0.3, 0.9) * static_cast<double>(bytes.size()))] ^=
        static_cast<char>(1 << flip % 8);
  const Ran ran =
      run({write("bits.mp4", bytes), "--site", (sample("straight") / "site.yaml").string()});
  expect_told(ran, 4, {"bits.mp4", "frames are damaged", "the first is frame", "copy the clip"});
  EXPECT_EQ(test::files_in(out()), kOutputs);
}

TEST_F(Broken, ClipThatChangesItsSizeIsFourAndNamesTheFrame) {
  ClipSpec small{
      .path = path("small.mjpeg"), .encoder = "mjpeg", .pixel_format = "yuvj420p", .frames = 6};
  ClipSpec large = small;
  large.path = path("large.mjpeg");
  large.width_px = 128;
  const std::string both = test::bytes_of(clip(small)) + test::bytes_of(clip(large));
  expect_told(
      run({write("both.mjpeg", both), "--site", site(), "--annotate"}), 4,
      {"both.mjpeg", "6 frames are not 64 x 48 pixels", "the first is frame 6", "cut the clip"});
}

TEST_F(Broken, StampsThatJumpOrRepeatAreFourAndNameTheFrame) {
  ClipSpec spec{.path = path("stamps.mkv"), .width_px = 16, .height_px = 8, .frames = 30};
  spec.keyframe_interval = 1;
  for (int k = 0; k < 30; ++k) spec.stamps_ms.push_back(40 * k);
  const std::string file = clip(spec);
  test::restamp(file, 400, 100);    // back
  test::restamp(file, 600, 560);    // again
  test::restamp(file, 800, 20000);  // far ahead
  expect_told(run({file, "--site", site(16, 8)}), 4,
              {"stamps.mkv", "3 time stamps", "the first at frame 10", "give the frame rate"});
  expect_told(run({file, "--site", site(16, 8), "--frame-rate", "25"}), 0, {});
}

TEST_F(Broken, AVariableRateIsNoDamage) {
  ClipSpec spec{.path = path("variable.mkv"), .frames = 40};
  for (int k = 0; k < 40; ++k) spec.stamps_ms.push_back(25 * k + k * k * 7 % 19);
  const Ran ran = run({clip(spec), "--site", site()});
  expect_told(ran, 0, {});
  EXPECT_NE(run_json().find("\"time_stamps_repaired\": 0"), std::string::npos);
}

TEST_F(Broken, ATurnedClipNeedsTheSiteOfItsUprightImage) {
  const std::string file = clip(
      {.path = path("turned.mp4"), .encoder = "mpeg4", .frames = 5, .rotate_clockwise_deg = 90});
  expect_told(run({file, "--site", site()}), 2,
              {"site.yaml", "camera.image_size_px", "64 x 48", "48 x 64", "upright"});
  expect_told(run({file, "--site", site(48, 64), "--annotate"}), 0, {});
}

TEST_F(Broken, OnePixelIsAClip) {
  const ClipSpec spec{
      .path = path("one.mkv"), .pixel_format = "gray", .width_px = 1, .height_px = 1, .frames = 3};
  test::write_clip(spec, test::luma_painter([](int frame, int, int) { return 100 * frame; }));
  const std::string file = spec.path.string();
  expect_told(run({file, "--site", site()}), 2, {"1 x 1", "64 x 48"});
  expect_told(run({file, "--site", site(1, 1), "--annotate", "--blobs"}), 0, {});
}

TEST_F(Broken, SixteenThousandPixelsAreAClip) {
  const ClipSpec spec{.path = path("large.mkv"),
                      .pixel_format = "gray",
                      .width_px = 15360,
                      .height_px = 8640,
                      .frames = 1};
  test::write_clip(spec, [](AVFrame& picture, int) {
    std::fill_n(picture.data[0], picture.linesize[0] * picture.height, std::uint8_t{16});
  });
  expect_told(run({spec.path.string(), "--site", site(15360, 8640)}), 0, {});
}

}  // namespace
}  // namespace vildar
