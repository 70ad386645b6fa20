#pragma once

#include <functional>

namespace vildar {

/// Goes through two ranges in order of frames at once: `each(item of first, item of second)` for
/// every frame that both have. `frame_of` an item tells its frame; no range has two of one frame.
template <class A, class B, class FrameOf, class Each>
void for_each_common_frame(const A& first, const B& second, FrameOf frame_of, Each each) {
  auto a = first.begin();
  auto b = second.begin();
  while (a != first.end() && b != second.end()) {
    const auto frame_a = std::invoke(frame_of, *a), frame_b = std::invoke(frame_of, *b);
    if (frame_a == frame_b) each(*a, *b);
    a += frame_a <= frame_b;
    b += frame_b <= frame_a;
  }
}

}  // namespace vildar
