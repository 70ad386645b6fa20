#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace vildar::test {

struct DecodedFrame {
  double t_s = 0.0;
  std::vector<std::uint8_t> luma;  ///< rows without padding
};

struct DecodedClip {
  std::string codec;
  int width_px = 0;
  int height_px = 0;
  std::vector<DecodedFrame> frames;
};

/// Every frame of a video file by libavcodec; throws std::runtime_error where it does not decode.
DecodedClip decode(const std::filesystem::path& path);

}  // namespace vildar::test
