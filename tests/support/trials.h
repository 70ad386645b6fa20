#pragma once

#include <algorithm>

namespace vildar {

/// Of a test that repeats one thing with random numbers: as many trials as asked for, but a quarter
/// under the address sanitizer, where each takes ten times as long and the same code is seen by the
/// first few.
constexpr int trials(int asked_for) {
#ifdef __SANITIZE_ADDRESS__
  return std::max(1, asked_for / 4);
#else
  return asked_for;
#endif
}

}  // namespace vildar
