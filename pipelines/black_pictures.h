#pragma once

#include <cstdint>
#include <optional>

#include "types/frame.h"

namespace vildar {

/// Looks for a camera that fails in the midst of a clip: from one picture to the next the lights
/// are gone, and with them the noise and the night sky that most of the picture showed, for half a
/// second at least. A dark road shows its noise, and lights leave it one by one.
class BlackPictures {
 public:
  struct Stretch {
    double from_s = 0.0, to_s = 0.0;  ///< times of its first and last picture
    std::int64_t frames = 0;
  };

  /// Frames in order of time; `lit`: lights were found in it.
  void add(const Frame& frame, bool lit);

  /// The longest.
  const std::optional<Stretch>& longest() const { return longest_; }

 private:
  bool showed_ = false;  ///< the last picture that was not black: lights, and more than black
  std::optional<Stretch> now_, longest_;
};

}  // namespace vildar
