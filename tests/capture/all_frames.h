#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "capture/clip_source.h"

namespace vildar {

/// What is left of a clip.
inline std::vector<Frame> all_frames(ClipSource& source) {
  std::vector<Frame> frames;
  while (std::optional<Frame> frame = source.next()) frames.push_back(std::move(*frame));
  return frames;
}

}  // namespace vildar
