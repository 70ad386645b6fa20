#pragma once

#include <complex>
#include <span>
#include <vector>

#include "types/power.h"

namespace vildar {

inline constexpr double kLineBlock_s = 0.1;

/// Samples [first, last) of a trace that share a tenth of a second: about whole periods of 50 and
/// 60 Hz and of all their multiples.
struct LineBlock {
  std::size_t first = 0, last = 0;
  double time_s = 0.0;  ///< mean of their times
  bool whole = false;   ///< no sample to speak of is missing
  bool even = false;    ///< stamps evenly spaced, but for rounding
};

/// A trace in such blocks, for looking at single frequencies in it.
class LineBlocks {
 public:
  /// `trace` must outlive it and keep its times; needs sample_period_s.
  explicit LineBlocks(const PowerTrace& trace);

  const std::vector<LineBlock>& blocks() const { return blocks_; }
  double sample_rate_hz() const { return 1.0 / step_s_; }

  /// Whether a light at this frequency can be told from a slow one, and its phase seen: neither it
  /// nor its double is sampled as less than 15 Hz.
  bool visible(double frequency_hz) const;
  /// Whether light at these two can be told apart: sampled, they lie 15 Hz from each other.
  bool distinct(double one_hz, double other_hz) const;

  /// Complex amplitude z at frequency f in each of blocks [first, last), light =
  /// Re(z exp(i 2 pi f (t - time_s))) beside a constant, a slope and light at the other
  /// frequencies, by least squares; 0 where the block is not whole. All frequencies must be visible
  /// and distinct.
  std::vector<std::complex<double>> amplitudes(double frequency_hz,
                                               std::span<const double> others_hz, std::size_t first,
                                               std::size_t last) const;

  /// Takes from the samples of every block the light of that frequency with the given amplitudes at
  /// the blocks' times, linear in between.
  void subtract(double frequency_hz, const std::vector<std::complex<double>>& amplitudes,
                PowerTrace& trace) const;

 private:
  const PowerTrace& trace_;
  std::vector<LineBlock> blocks_;
  double step_s_ = 0.0;  ///< between samples
};

}  // namespace vildar
