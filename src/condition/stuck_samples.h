#pragma once

#include <cstddef>
#include <vector>

namespace vildar {

/// Samples [first, last).
struct Span {
  std::size_t first = 0, last = 0;
};

/// Stretches in which a sensor or its logger hangs: at least 0.05 s of exactly equal samples, more
/// in a row than noise gives once in 1e9 such traces. How much of the noise the record shows is
/// told by the greatest share of equal neighbours among the 100 samples before, the 100 after and
/// all that are no brighter (noise grows with light). Where that is over 0.4, as in the dark of a
/// coarse converter or in light without noise, nothing can be told and none is stuck; nor where
/// fewer than 100 are no brighter, but for a lowest value that stands apart (below). In order.
/// Stamps in seconds, increasing; as many as values.
std::vector<Span> stuck_runs(const std::vector<double>& time_s, const std::vector<float>& values);

/// Whether no other value comes near `lowest`, the least of all, by the noise between neighbours,
/// which must show: a sensor without its cable or supply, and not the dark or a converter's end,
/// into which noise and light fall by degrees.
bool stands_apart(const std::vector<float>& values, float lowest);

}  // namespace vildar
