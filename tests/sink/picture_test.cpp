#include "sink/picture.h"

#include "sink/picture_support.h"

namespace vildar {
namespace {

using test::made_frame;

TEST(Picture, LimitedAndFullRangeMeanTheSameGrey) {
  // (126 - 16) / 219 of white is 128.08 codes of full range.
  const auto limited = made_frame(8, 6, 126);
  const auto full = made_frame(8, 6, 128, true);
  EXPECT_EQ(upright_picture(limited.frame).at<cv::Vec3b>(3, 4), cv::Vec3b::all(128));
  EXPECT_EQ(upright_picture(full.frame).at<cv::Vec3b>(3, 4), cv::Vec3b::all(128));
}

TEST(Picture, CodesBeyondBlackAndWhiteAreCut) {
  EXPECT_EQ(upright_picture(made_frame(4, 4, 2).frame).at<cv::Vec3b>(0, 0), cv::Vec3b::all(0));
  EXPECT_EQ(upright_picture(made_frame(4, 4, 254).frame).at<cv::Vec3b>(0, 0), cv::Vec3b::all(255));
}

TEST(Picture, PureRedOfBothStandards) {
  // BT.601, limited: Y = 16 + 219 * 0.299, Cb = 128 - 224 * 0.299 / 1.772, Cr = 128 + 112.
  auto small = made_frame(8, 8, 81);
  std::fill(small.planes->begin() + 64, small.planes->begin() + 80, std::uint8_t{90});
  std::fill(small.planes->begin() + 80, small.planes->end(), std::uint8_t{240});
  const auto red = upright_picture(small.frame).at<cv::Vec3b>(4, 4);
  EXPECT_NEAR(red[2], 255, 2);
  EXPECT_NEAR(red[1], 0, 2);
  EXPECT_NEAR(red[0], 0, 2);
  // BT.709: Y = 16 + 219 * 0.2126, Cb = 128 - 224 * 0.2126 / 1.8556.
  auto large = made_frame(1280, 2, 63);
  for (int u = 0; u < 1280; ++u) {
    large.cb(u, 0) = 102;
    large.cr(u, 0) = 240;
  }
  const auto red_709 = upright_picture(large.frame).at<cv::Vec3b>(1, 600);
  EXPECT_NEAR(red_709[2], 255, 2);
  EXPECT_NEAR(red_709[1], 0, 2);
  EXPECT_NEAR(red_709[0], 0, 2);
}

TEST(Picture, TurnsUpright) {
  // A clockwise quarter turn moves stored (u, v) to (H - 1 - v, u).
  auto made = made_frame(7, 5, 16);
  made.luma(6, 1) = 235;
  const auto is_white = [&](int rotation_deg, int u, int v) {
    made.frame.rotation_deg = rotation_deg;
    return upright_picture(made.frame).at<cv::Vec3b>(v, u) == cv::Vec3b::all(255);
  };
  EXPECT_TRUE(is_white(0, 6, 1));
  EXPECT_TRUE(is_white(90, 3, 6));
  EXPECT_TRUE(is_white(180, 0, 3));
  EXPECT_TRUE(is_white(270, 1, 0));
  made.frame.rotation_deg = 90;
  EXPECT_EQ(upright_picture(made.frame).size(), cv::Size(5, 7));
}

TEST(Picture, TenBitsGreyOnly) {
  const auto words = std::make_shared<std::vector<std::uint16_t>>(12, std::uint16_t{504});
  Frame frame;
  frame.luma.owner = words;
  frame.luma.data = reinterpret_cast<const std::uint8_t*>(words->data());
  frame.luma.stride_bytes = 8;
  frame.luma.width_px = 4;
  frame.luma.height_px = 3;
  frame.luma.bit_depth = 10;
  frame.luma.black_code = 64;
  frame.luma.white_code = 940;
  // (504 - 64) / 876 * 255 = 128.08.
  EXPECT_EQ(upright_picture(frame).at<cv::Vec3b>(2, 3), cv::Vec3b::all(128));
}

TEST(Picture, FrameWithoutPixelsIsEmpty) { EXPECT_TRUE(upright_picture(Frame{}).empty()); }

}  // namespace
}  // namespace vildar
