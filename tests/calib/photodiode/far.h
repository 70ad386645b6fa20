#pragma once

namespace vildar {

/// Sigmas: five of a normal error are one in two million.
inline constexpr double kFar = 5.0;

}  // namespace vildar
