#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

struct AVFrame;

namespace vildar::test {

/// A clip to be made. The container follows the path's extension.
struct ClipSpec {
  std::filesystem::path path;
  std::string encoder = "ffv1";
  std::string pixel_format = "yuv420p";
  int width_px = 64;
  int height_px = 48;
  int frames = 30;
  int rate_hz = 25;
  std::vector<std::int64_t> stamps_ms = {};  ///< one per frame; empty: steady at rate_hz
  int rotate_clockwise_deg = 0;
  bool full_range = false;
  bool state_range = true;  ///< false: the clip does not say which range it is in
  int keyframe_interval = 10;
  std::array<int, 2> pixel_aspect{0, 1};  ///< width, height; 0: not declared
  std::map<std::string, std::string> encoder_options = {}, muxer_options = {};
};

/// Fills a writable picture; called once per frame in order.
using Painter = std::function<void(AVFrame& picture, int frame)>;

/// Painter that sets plane 0 to code(frame, u, v), other planes to the middle code. Planar YUV and
/// grey only.
Painter luma_painter(std::function<int(int frame, int u, int v)> code);

/// Eight vertical bars, dark for a 0 and bright for a 1, that spell the frame's index, lowest bit
/// leftmost.
Painter index_painter();

/// Throws std::runtime_error where the installed FFmpeg cannot make it.
void write_clip(const ClipSpec& spec, const Painter& paint);

}  // namespace vildar::test
