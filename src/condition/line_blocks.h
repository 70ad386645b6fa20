#pragma once

#include <complex>
#include <map>
#include <vector>

#include <Eigen/Core>

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
  const PowerTrace& trace() const { return trace_; }
  double sample_rate_hz() const { return 1.0 / step_s_; }

  /// Whether a light at this frequency can be told from a slow one, and its phase seen: neither it
  /// nor its double is sampled as less than 15 Hz.
  bool visible(double frequency_hz) const;
  /// Whether light at these two can be told apart: sampled, they lie 15 Hz from each other.
  bool distinct(double one_hz, double other_hz) const;

  /// Takes from the samples of every block the light of that frequency with the given amplitudes at
  /// the blocks' times, linear in between.
  void subtract(double frequency_hz, const std::vector<std::complex<double>>& amplitudes,
                PowerTrace& trace) const;

 private:
  const PowerTrace& trace_;
  std::vector<LineBlock> blocks_;
  double step_s_ = 0.0;  ///< between samples
};

/// Light at one frequency beside a constant, a slope and light at others, by least squares.
class LineFilter {
 public:
  /// `lines` must outlive it; all frequencies must be visible and distinct.
  LineFilter(const LineBlocks& lines, double frequency_hz, std::vector<double> others_hz);

  double frequency_hz() const { return frequency_hz_; }
  const LineBlocks& lines() const { return lines_; }

  /// Complex amplitude z in each of blocks [first, last), light = Re(z exp(i 2 pi f (t - time_s)));
  /// 0 where the block is not whole. Not from several threads at once.
  std::vector<std::complex<double>> amplitudes(std::size_t first, std::size_t last);

 private:
  /// What a block's samples are multiplied with and summed.
  struct Kernel {
    Eigen::VectorXd re, im;
  };
  Kernel kernel_of(const Eigen::VectorXd& after_s) const;

  const LineBlocks& lines_;
  double frequency_hz_ = 0.0;
  std::vector<double> others_hz_;
  std::map<std::size_t, Kernel> even_;  ///< of blocks evenly stamped, by number of samples
};

}  // namespace vildar
