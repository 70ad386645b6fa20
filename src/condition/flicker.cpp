#include "condition/flicker.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <set>
#include <span>
#include <utility>

#include "condition/line_blocks.h"
#include "condition/noise.h"
#include "core/quantity.h"

namespace vildar {
namespace {

using Complex = std::complex<double>;

constexpr int kMultiples = 8;
constexpr double kMostWander_hz = 0.2;
constexpr std::size_t kStretch = 100;  // blocks in which a frequency is looked for
constexpr std::size_t kFewest = 20;    // blocks
constexpr double kMostOff_hz = 0.3;    // of the mains
constexpr double kMostStretches = 10.0;

/// Of a number that is neither huge nor tiny; that of the library looks out for both.
double magnitude(const Complex& number) { return std::sqrt(std::norm(number)); }

double median_magnitude(std::span<const Complex> amplitudes) {
  std::vector<double> magnitudes;
  magnitudes.reserve(amplitudes.size());
  for (const Complex& amplitude : amplitudes)
    if (amplitude != 0.0) magnitudes.push_back(magnitude(amplitude));
  return magnitudes.empty() ? 0.0 : median_of(magnitudes);
}

/// Makes no magnitude larger than `most`, so that a vehicle's edge does not count for more than the
/// flicker does.
void tame(std::span<Complex> amplitudes, double most) {
  for (Complex& amplitude : amplitudes)
    if (const double size = magnitude(amplitude); size > most) amplitude *= most / size;
}
constexpr double kMostMedians = 1.5;

/// Of finite numbers; that of the library looks for infinite ones, too.
Complex product(const Complex& one, const Complex& other) {
  return {one.real() * other.real() - one.imag() * other.imag(),
          one.real() * other.imag() + one.imag() * other.real()};
}

/// Amplitudes of blocks [first, last), up to a gap, as they are at one frequency through all of
/// them.
class Stretch {
 public:
  Stretch(LineFilter& filter, std::size_t first, std::size_t last)
      : amplitudes_(filter.amplitudes(first, last)) {
    const std::vector<LineBlock>& blocks = filter.lines().blocks();
    tame(amplitudes_, kMostMedians * median_magnitude(amplitudes_));
    constexpr double kLongest_s = 20.0;  // the clock may also have been set meanwhile
    for (std::size_t j = first; j < last; ++j) {
      const double time_s = blocks[j].time_s - blocks[first].time_s;
      if (time_s > kLongest_s) break;
      times_s_.push_back(time_s);
      amplitudes_[j - first] *= std::polar(1.0, -2.0 * kPi * filter.frequency_hz() * time_s);
    }
  }

  /// Squared sum at a frequency that is `off_hz` higher.
  double power(double off_hz) const {
    Complex sum = 0.0;
    for (std::size_t j = 0; j < times_s_.size(); ++j)
      sum += amplitudes_[j] * std::polar(1.0, -2.0 * kPi * off_hz * times_s_[j]);
    return std::norm(sum);
  }

  /// The same at `count` frequencies, `step_hz` apart, from `first_off_hz` on to either side.
  struct Powers {
    std::vector<double> higher, lower;
  };
  Powers powers(double first_off_hz, double step_hz, std::size_t count) const {
    std::vector<Complex> phase, step;
    for (const double time_s : times_s_) {
      phase.push_back(std::polar(1.0, -2.0 * kPi * first_off_hz * time_s));
      step.push_back(std::polar(1.0, -2.0 * kPi * step_hz * time_s));
    }
    Powers found;
    for (std::size_t k = 0; k < count; ++k) {
      Complex higher = 0.0, lower = 0.0;
      for (std::size_t j = 0; j < phase.size(); ++j) {
        higher += product(amplitudes_[j], phase[j]);
        lower += product(amplitudes_[j], std::conj(phase[j]));
        phase[j] = product(phase[j], step[j]);
      }
      found.higher.push_back(std::norm(higher));
      found.lower.push_back(std::norm(lower));
    }
    return found;
  }

  std::size_t blocks() const { return times_s_.size(); }
  double length_s() const { return times_s_.back(); }

 private:
  std::vector<double> times_s_;
  std::vector<Complex> amplitudes_;
};

struct Peak {
  double off_hz = 0.0;
  double power = 0.0;
  double over_floor = 0.0;  ///< power over the median of that at other frequencies nearby
};

Peak find_peak(const Stretch& stretch, double reach_hz) {
  constexpr double kFloorFrom_hz = 1.5, kFloorStep_hz = 0.25;
  constexpr std::size_t kFloors = 12;
  auto [floor, floor_below] = stretch.powers(kFloorFrom_hz, kFloorStep_hz, kFloors);
  floor.insert(floor.end(), floor_below.begin(), floor_below.end());
  const double step_hz = 0.25 / stretch.length_s();
  const auto steps = static_cast<std::ptrdiff_t>(reach_hz / step_hz);
  const auto sides = stretch.powers(0.0, step_hz, static_cast<std::size_t>(steps) + 2);
  const auto power_at = [&](std::ptrdiff_t k) {
    return k < 0 ? sides.lower[static_cast<std::size_t>(-k)]
                 : sides.higher[static_cast<std::size_t>(k)];
  };
  std::ptrdiff_t highest = -steps;
  for (std::ptrdiff_t k = -steps; k <= steps; ++k)
    if (power_at(k) > power_at(highest)) highest = k;
  Peak peak{.off_hz = static_cast<double>(highest) * step_hz, .power = power_at(highest)};
  // A parabola through the top.
  const double below = power_at(highest - 1), above = power_at(highest + 1);
  const double bend = below - 2.0 * peak.power + above;
  if (bend < 0.0) peak.off_hz += std::clamp(0.5 * (below - above) / bend, -1.0, 1.0) * step_hz;
  const double median = median_of(floor);
  peak.over_floor = median > 0.0 ? peak.power / median : 0.0;
  return peak;
}

/// Stretches spread evenly over the trace, as first blocks; all of a short one.
std::vector<std::size_t> stretches_of(std::size_t blocks) {
  if (blocks <= kStretch) return {0};
  const double all = static_cast<double>(blocks / kStretch);
  const double count = std::min(all, kMostStretches);
  std::vector<std::size_t> first;
  for (double i = 0.0; i < count; ++i)
    first.push_back(static_cast<std::size_t>(i * all / count) * kStretch);
  return first;
}

/// One multiple of a mains frequency as the trace has it.
struct Line {
  double power = 0.0;   ///< of the stretch that shows it most; 0: none does
  double off_hz = 0.0;  ///< median over the stretches that show it
};

/// Whether a peak is the bend of slow light: that has one phase in all blocks, as a line of whole
/// periods in a block has, but shows at the frequencies of a period more and a period less as well.
bool is_bend(const LineBlocks& lines, double frequency_hz, const Peak& peak, std::size_t first,
             std::size_t last) {
  constexpr double kOver = 4.0;
  double least = peak.power;
  for (const double side : {-1.0, 1.0})
    if (const double beside_hz = frequency_hz + side / kLineBlock_s; lines.visible(beside_hz)) {
      LineFilter beside(lines, beside_hz, {});
      least = std::min(least, Stretch(beside, first, last).power(peak.off_hz));
    } else {
      least = 0.0;
    }
  return kOver * least > peak.power;
}

Line look_for(const LineBlocks& lines, double frequency_hz, std::vector<double> others_hz,
              double reach_hz) {
  constexpr double kClear = 30.0;  // noise alone: one in ten million
  Line line;
  if (!lines.visible(frequency_hz)) return line;
  LineFilter filter(lines, frequency_hz, std::move(others_hz));
  std::vector<double> offs_hz;
  for (const std::size_t first : stretches_of(lines.blocks().size())) {
    const std::size_t last = std::min(first + kStretch, lines.blocks().size());
    const Stretch stretch(filter, first, last);
    if (stretch.blocks() < kFewest) continue;
    const Peak peak = find_peak(stretch, reach_hz);
    if (peak.over_floor < kClear || is_bend(lines, frequency_hz, peak, first, last)) continue;
    line.power = std::max(line.power, peak.power);
    offs_hz.push_back(peak.off_hz);
  }
  if (!offs_hz.empty()) line.off_hz = median_of(offs_hz);
  return line;
}

struct Mains {
  double frequency_hz = 0.0;  ///< as found
  double power = 0.0;         ///< 0: it does not show
};

Mains look_for_mains(const LineBlocks& lines, double nominal_hz) {
  Mains mains;
  for (const int multiple : {2, 1}) {
    const Line line = look_for(lines, multiple * nominal_hz, {}, multiple * kMostOff_hz);
    if (line.power > mains.power) mains = {nominal_hz + line.off_hz / multiple, line.power};
  }
  return mains;
}

/// Amplitudes of all blocks averaged over half a second to either side, each side turned by how far
/// the frequency is off there.
std::vector<Complex> followed(const LineBlocks& lines, double frequency_hz,
                              std::vector<double> others_hz) {
  constexpr std::size_t kReach = 5, kTamed = 30;
  const std::size_t n = lines.blocks().size();
  std::vector<Complex> found =
      LineFilter(lines, frequency_hz, std::move(others_hz)).amplitudes(0, n);
  const auto stretch = [&](std::size_t index) {
    const std::size_t first = index * kTamed;
    return std::span(found).subspan(first, std::min(kTamed, n - first));
  };
  std::vector<double> usual;
  for (std::size_t i = 0; i * kTamed < n; ++i) usual.push_back(median_magnitude(stretch(i)));
  for (std::size_t i = 0; i < usual.size(); ++i)
    tame(stretch(i), kMostMedians * std::max({usual[i], usual[i > 0 ? i - 1 : i],
                                              usual[std::min(i + 1, usual.size() - 1)]}));
  // In the phase of one time, and back in that of each block's own.
  std::vector<Complex> turn(n);
  for (std::size_t j = 0; j < n; ++j) {
    turn[j] = std::polar(1.0, -2.0 * kPi * frequency_hz *
                                  (lines.blocks()[j].time_s - lines.blocks().front().time_s));
    found[j] = product(found[j], turn[j]);
  }
  // How the phase goes on from block to block, in the mean over a stretch of some seconds.
  std::vector<Complex> step(n);
  for (std::size_t j = 0; j + 1 < n; ++j) step[j] = product(found[j + 1], std::conj(found[j]));
  std::vector<Complex> mean(n);
  Complex step_sum = 0.0;
  std::size_t begin = 0, end = 0;
  for (std::size_t j = 0; j < n; ++j) {
    while (end < std::min(n, j + kTamed)) step_sum += step[end++];
    while (begin + kTamed < j) step_sum -= step[begin++];
    const double size = magnitude(step_sum);
    const Complex back = size > 0.0 ? std::conj(step_sum) / size : 1.0;
    Complex sum = found[j], later = 1.0;
    double count = found[j] == 0.0 ? 0.0 : 1.0;
    for (std::size_t off = 1; off <= kReach; ++off) {
      later = product(later, back);
      if (j + off < n && found[j + off] != 0.0) {
        sum += product(found[j + off], later);
        count += 1.0;
      }
      if (j >= off && found[j - off] != 0.0) {
        sum += product(found[j - off], std::conj(later));
        count += 1.0;
      }
    }
    if (count > 0.0) mean[j] = product(sum, std::conj(turn[j])) / count;
  }
  return mean;
}

std::vector<double> without(std::vector<double> frequencies_hz, double frequency_hz) {
  std::erase(frequencies_hz, frequency_hz);
  return frequencies_hz;
}

}  // namespace

void remove_flicker(PowerTrace& trace, double mains_hz) {
  if (!(trace.sample_period_s > 0.0) || trace.time_s.size() < kFewest) return;
  const LineBlocks lines(trace);
  if (lines.blocks().size() < kFewest || !lines.visible(2.0 * mains_hz)) return;
  // A strong flicker that is a little off shows in the other's place too: the stronger one is it.
  Mains mains;
  for (const double nominal_hz : std::set{mains_hz, 50.0, 60.0}) {
    const Mains found = look_for_mains(lines, nominal_hz);
    if (found.power > mains.power) mains = found;
  }
  if (mains.power == 0.0) return;
  std::vector<double> candidates_hz, found_hz;
  for (int multiple = 1; multiple <= kMultiples; ++multiple) {
    const double frequency_hz = multiple * mains.frequency_hz;
    if (lines.visible(frequency_hz) &&
        std::all_of(candidates_hz.begin(), candidates_hz.end(),
                    [&](double other_hz) { return lines.distinct(frequency_hz, other_hz); }))
      candidates_hz.push_back(frequency_hz);
  }
  for (const double frequency_hz : candidates_hz)
    if (look_for(lines, frequency_hz, without(candidates_hz, frequency_hz), kMostWander_hz).power >
        0.0)
      found_hz.push_back(frequency_hz);
  std::vector<std::vector<Complex>> amplitudes;
  for (const double frequency_hz : found_hz)
    amplitudes.push_back(followed(lines, frequency_hz, without(found_hz, frequency_hz)));
  if (found_hz.empty()) return;
  double square_w2 = 0.0;
  for (const std::vector<Complex>& of_line : amplitudes)
    square_w2 += std::pow(median_magnitude(of_line), 2);
  if (trace.rounding_sigma_w > 0.0 && square_w2 < std::pow(trace.noise_sigma_w, 2)) return;
  for (std::size_t i = 0; i < found_hz.size(); ++i)
    lines.subtract(found_hz[i], amplitudes[i], trace);
  trace.mains_hz = mains.frequency_hz;
  trace.flicker_w = std::sqrt(square_w2);
}

}  // namespace vildar
