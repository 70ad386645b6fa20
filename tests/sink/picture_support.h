#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "types/frame.h"

namespace vildar::test {

/// A frame of one grey code and neutral chroma (4:2:0), limited range unless told; `planes` is its
/// memory.
struct MadeFrame {
  std::shared_ptr<std::vector<std::uint8_t>> planes;
  Frame frame;

  std::uint8_t& luma(int u, int v) {
    return (*planes)[static_cast<std::size_t>(v * frame.luma.width_px + u)];
  }
  std::uint8_t& cb(int u, int v) { return (*planes)[chroma_at(u, v)]; }
  std::uint8_t& cr(int u, int v) { return (*planes)[chroma_at(u, v) + chroma_size()]; }

 private:
  std::size_t chroma_size() const {
    return static_cast<std::size_t>((frame.luma.width_px + 1) / 2 *
                                    ((frame.luma.height_px + 1) / 2));
  }
  std::size_t chroma_at(int u, int v) const {
    return static_cast<std::size_t>(frame.luma.width_px * frame.luma.height_px +
                                    v / 2 * ((frame.luma.width_px + 1) / 2) + u / 2);
  }
};

inline MadeFrame made_frame(int width_px, int height_px, std::uint8_t grey_code,
                            bool full_range = false) {
  const int chroma_width = (width_px + 1) / 2, chroma_height = (height_px + 1) / 2;
  const auto luma_size = static_cast<std::size_t>(width_px * height_px);
  const auto chroma_size = static_cast<std::size_t>(chroma_width * chroma_height);
  MadeFrame made;
  made.planes =
      std::make_shared<std::vector<std::uint8_t>>(luma_size + 2 * chroma_size, std::uint8_t{128});
  std::fill_n(made.planes->begin(), luma_size, grey_code);
  LumaView& luma = made.frame.luma;
  luma.owner = made.planes;
  luma.data = made.planes->data();
  luma.stride_bytes = width_px;
  luma.width_px = width_px;
  luma.height_px = height_px;
  luma.black_code = full_range ? 0 : 16;
  luma.white_code = full_range ? 255 : 235;
  made.frame.chroma.cb = made.planes->data() + luma_size;
  made.frame.chroma.cr = made.planes->data() + luma_size + chroma_size;
  made.frame.chroma.stride_bytes = chroma_width;
  return made;
}

}  // namespace vildar::test
