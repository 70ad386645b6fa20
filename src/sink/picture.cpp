#include "sink/picture.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace vildar {
namespace {

// Fixed point with 14 fraction bits keeps rounding below half a code.
constexpr int kFractionBits = 14;
constexpr int kOne = 1 << kFractionBits;

/// Contribution of a Cb or Cr code to each of two channels, in fixed point of 8-bit output codes.
struct ChromaTerm {
  int first = 0;
  int second = 0;
};

/// Per-code tables, so that depth, range and matrix cost nothing per pixel.
struct Tables {
  std::vector<int> luma;
  std::vector<ChromaTerm> cb;  // first: blue, second: green
  std::vector<ChromaTerm> cr;  // first: red, second: green
};

int fixed_point(double value) { return static_cast<int>(std::lround(value * kOne)); }

Tables tables_for(const Frame& frame) {
  const LumaView& luma = frame.luma;
  const double span_codes = luma.white_code - luma.black_code;
  Tables tables;
  // Padding bits beyond the depth cannot occur in a valid plane; the tables still cover whole
  // words.
  tables.luma.resize(luma.bit_depth > 8 ? 65536 : 256);
  for (std::size_t code = 0; code < tables.luma.size(); ++code)
    tables.luma[code] = fixed_point(
        255.0 * std::clamp((static_cast<double>(code) - luma.black_code) / span_codes, -0.1, 1.2));
  if (!frame.chroma.present()) return tables;

  const bool high_definition = std::max(luma.width_px, luma.height_px) >= 1280;
  const double red = high_definition ? 0.2126 : 0.299;
  const double blue = high_definition ? 0.0722 : 0.114;
  const double green = 1.0 - red - blue;
  const ChromaView& chroma = frame.chroma;
  const double middle = std::exp2(chroma.bit_depth - 1);
  // Limited range spreads chroma over 224/219 of the luma's codes.
  const bool limited = luma.black_code > 0;
  const double chroma_span = limited ? 224.0 * std::exp2(chroma.bit_depth - 8) : 2.0 * middle - 1.0;
  tables.cb.resize(chroma.bit_depth > 8 ? 65536 : 256);
  tables.cr.resize(tables.cb.size());
  for (std::size_t code = 0; code < tables.cb.size(); ++code) {
    const double value =
        255.0 * std::clamp((static_cast<double>(code) - middle) / chroma_span, -1.0, 1.0);
    tables.cb[code] = {fixed_point(2.0 * (1.0 - blue) * value),
                       fixed_point(-2.0 * (1.0 - blue) * blue / green * value)};
    tables.cr[code] = {fixed_point(2.0 * (1.0 - red) * value),
                       fixed_point(-2.0 * (1.0 - red) * red / green * value)};
  }
  return tables;
}

std::uint8_t rounded(int value) {
  return static_cast<std::uint8_t>(std::clamp((value + kOne / 2) >> kFractionBits, 0, 255));
}

int code_at(const std::uint8_t* row, int index, bool wide) {
  if (!wide) return row[index];
  return row[2 * index] | row[2 * index + 1] << 8;
}

cv::Mat stored_picture(const Frame& frame) {
  const LumaView& luma = frame.luma;
  const ChromaView& chroma = frame.chroma;
  const Tables tables = tables_for(frame);
  const bool wide_luma = luma.bit_depth > 8;
  const bool wide_chroma = chroma.bit_depth > 8;
  cv::Mat picture(luma.height_px, luma.width_px, CV_8UC3);
  for (int v = 0; v < luma.height_px; ++v) {
    auto* out = picture.ptr<cv::Vec3b>(v);
    const std::uint8_t* row = luma.row(v);
    if (!chroma.present()) {
      for (int u = 0; u < luma.width_px; ++u)
        out[u] = cv::Vec3b::all(rounded(tables.luma[code_at(row, u, wide_luma)]));
      continue;
    }
    const std::ptrdiff_t offset_bytes = (v >> chroma.shift_v) * chroma.stride_bytes;
    for (int u = 0; u < luma.width_px; ++u) {
      const int grey = tables.luma[code_at(row, u, wide_luma)];
      const int index = (u >> chroma.shift_u) * chroma.step_bytes;
      const ChromaTerm& cb = tables.cb[code_at(chroma.cb + offset_bytes, index, wide_chroma)];
      const ChromaTerm& cr = tables.cr[code_at(chroma.cr + offset_bytes, index, wide_chroma)];
      out[u] = {rounded(grey + cb.first), rounded(grey + cb.second + cr.second),
                rounded(grey + cr.first)};
    }
  }
  return picture;
}

}  // namespace

cv::Mat upright_picture(const Frame& frame) {
  if (frame.luma.data == nullptr || frame.luma.width_px <= 0 || frame.luma.height_px <= 0)
    return {};
  const cv::Mat stored = stored_picture(frame);
  cv::Mat upright;
  switch (frame.rotation_deg) {
    case 90: cv::rotate(stored, upright, cv::ROTATE_90_CLOCKWISE); return upright;
    case 180: cv::rotate(stored, upright, cv::ROTATE_180); return upright;
    case 270: cv::rotate(stored, upright, cv::ROTATE_90_COUNTERCLOCKWISE); return upright;
    default: return stored;
  }
}

}  // namespace vildar
