#include "condition/line_blocks.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <Eigen/Dense>

#include "condition/stamps.h"
#include "core/quantity.h"

namespace vildar {
namespace {

constexpr double kApart_hz = 15.0;

using Complex = std::complex<double>;

Eigen::VectorXd even_times_s(std::size_t samples, double step_s) {
  const double half = 0.5 * static_cast<double>(samples - 1);
  return (Eigen::VectorXd::LinSpaced(static_cast<Eigen::Index>(samples), -half, half)) * step_s;
}

Eigen::VectorXd own_times_s(const PowerTrace& trace, const LineBlock& block) {
  return Eigen::Map<const Eigen::VectorXd>(trace.time_s.data() + block.first,
                                           static_cast<Eigen::Index>(block.last - block.first))
             .array() -
         block.time_s;
}

/// Distance of a frequency from the nearest that is sampled as a constant.
double sampled_as_hz(double frequency_hz, double rate_hz) {
  return std::abs(frequency_hz - rate_hz * std::round(frequency_hz / rate_hz));
}

}  // namespace

LineBlocks::LineBlocks(const PowerTrace& trace) : trace_(trace) {
  const std::vector<double>& time_s = trace.time_s;
  const double expected = kLineBlock_s / trace.sample_period_s;
  const std::ptrdiff_t usual = usual_samples(trace, kLineBlock_s);
  double step_sum_s = 0.0, steps = 0.0;
  for (std::size_t i = 0; i < time_s.size();) {
    const double index = std::floor((time_s[i] - time_s.front()) / kLineBlock_s + 1e-6);
    const double end_s = time_s.front() + (index + 1.0 - 1e-6) * kLineBlock_s;
    // Rounding of large times may put a block's first sample at its very end.
    const auto from = time_s.begin() + static_cast<std::ptrdiff_t>(i);
    const auto end = first_not_before(from + 1, time_s.end(), end_s, usual);
    LineBlock block{i, i + static_cast<std::size_t>(end - from), 0.0, false, false};
    const auto n = static_cast<double>(end - from);
    block.time_s = *from + (Eigen::Map<const Eigen::ArrayXd>(&*from, end - from) - *from).mean();
    block.whole = n >= 8.0 && n > 0.9 * expected - 1.0;
    if (block.whole) {
      step_sum_s += time_s[block.last - 1] - time_s[block.first];
      steps += n - 1.0;
    }
    blocks_.push_back(block);
    i = block.last;
  }
  step_s_ = steps > 0.0 ? step_sum_s / steps : trace.sample_period_s;
  const double rounding_s = std::min(0.25 * step_s_, 1e-4);
  for (LineBlock& block : blocks_) {
    const double from_s =
        block.time_s - 0.5 * step_s_ * static_cast<double>(block.last - block.first - 1);
    if (!block.whole) continue;
    const auto samples = static_cast<int>(block.last - block.first);
    int off = 0;
    for (int k = 0; k < samples; ++k)
      off |= !(std::abs(time_s[block.first + static_cast<std::size_t>(k)] - from_s - step_s_ * k) <
               rounding_s);
    block.even = off == 0;
  }
}

bool LineBlocks::visible(double frequency_hz) const {
  return sampled_as_hz(frequency_hz, sample_rate_hz()) >= kApart_hz &&
         sampled_as_hz(2.0 * frequency_hz, sample_rate_hz()) >= kApart_hz;
}

bool LineBlocks::distinct(double one_hz, double other_hz) const {
  return sampled_as_hz(one_hz - other_hz, sample_rate_hz()) >= kApart_hz &&
         sampled_as_hz(one_hz + other_hz, sample_rate_hz()) >= kApart_hz;
}

void LineBlocks::subtract(double frequency_hz, const std::vector<Complex>& amplitudes,
                          PowerTrace& trace) const {
  const double omega = 2.0 * kPi * frequency_hz;
  std::map<std::size_t, Eigen::ArrayX3f> even;  // time over a block, cosine, sine
  const auto waves_of = [&](const Eigen::VectorXd& after_s) {
    Eigen::ArrayX3f waves(after_s.size(), 3);
    waves.col(0) = (after_s / kLineBlock_s).cast<float>();
    waves.col(1) = (omega * after_s).array().cos().cast<float>();
    waves.col(2) = (omega * after_s).array().sin().cast<float>();
    return waves;
  };
  Eigen::ArrayX3f uneven;
  Complex to_after = 1.0;
  for (std::size_t j = 0; j < blocks_.size(); ++j) {
    const LineBlock& block = blocks_[j];
    const std::size_t n = block.last - block.first;
    const Eigen::ArrayX3f* waves = &uneven;
    if (block.even) {
      auto known = even.find(n);
      if (known == even.end()) known = even.emplace(n, waves_of(even_times_s(n, step_s_))).first;
      waves = &known->second;
    } else {
      uneven = waves_of(own_times_s(trace, block));
    }
    // In this block's phase, what the neighbours have; their slope across one block.
    const std::size_t before = j > 0 ? j - 1 : j, after = j + 1 < blocks_.size() ? j + 1 : j;
    const double apart_s = blocks_[after].time_s - blocks_[before].time_s;
    const Complex from_before = to_after;  // how far a wave turns from there to here
    to_after = std::polar(1.0, omega * (blocks_[after].time_s - block.time_s));
    Complex slope = 0.0;
    if (apart_s > 0.0 && apart_s < 3.0 * kLineBlock_s)
      slope = (amplitudes[after] * std::conj(to_after) - amplitudes[before] * from_before) *
              (kLineBlock_s / apart_s);
    const auto re = static_cast<float>(amplitudes[j].real());
    const auto im = static_cast<float>(amplitudes[j].imag());
    const auto re_slope = static_cast<float>(slope.real());
    const auto im_slope = static_cast<float>(slope.imag());
    const auto u = waves->col(0);
    Eigen::Map<Eigen::ArrayXf>(trace.power_w.data() + block.first, static_cast<Eigen::Index>(n)) -=
        (re + re_slope * u) * waves->col(1) - (im + im_slope * u) * waves->col(2);
  }
}

LineFilter::LineFilter(const LineBlocks& lines, double frequency_hz, std::vector<double> others_hz)
    : lines_(lines), frequency_hz_(frequency_hz), others_hz_(std::move(others_hz)) {}

/// `after_s` are the samples' times after the middle of their block.
LineFilter::Kernel LineFilter::kernel_of(const Eigen::VectorXd& after_s) const {
  Eigen::MatrixXd model(after_s.size(), 4 + 2 * static_cast<Eigen::Index>(others_hz_.size()));
  Eigen::Index column = 0;
  const auto add = [&](double added_hz) {
    model.col(column++) = (2.0 * kPi * added_hz * after_s).array().cos();
    model.col(column++) = -(2.0 * kPi * added_hz * after_s).array().sin();
  };
  add(frequency_hz_);
  for (const double other_hz : others_hz_) add(other_hz);
  model.col(column++).setOnes();
  model.col(column++) = after_s / kLineBlock_s;
  const Eigen::MatrixXd normal = model.transpose() * model;
  const Eigen::MatrixXd rows = model * normal.ldlt().solve(Eigen::MatrixXd::Identity(column, 2));
  return {rows.col(0), rows.col(1)};
}

std::vector<Complex> LineFilter::amplitudes(std::size_t first, std::size_t last) {
  const PowerTrace& trace = lines_.trace();
  Kernel uneven;
  Eigen::VectorXd light;
  std::vector<Complex> found(last - first);
  for (std::size_t j = first; j < last; ++j) {
    const LineBlock& block = lines_.blocks()[j];
    if (!block.whole) continue;
    const std::size_t n = block.last - block.first;
    const Kernel* kernel = &uneven;
    if (block.even) {
      auto known = even_.find(n);
      if (known == even_.end())
        known = even_.emplace(n, kernel_of(even_times_s(n, 1.0 / lines_.sample_rate_hz()))).first;
      kernel = &known->second;
    } else {
      uneven = kernel_of(own_times_s(trace, block));
    }
    const float* light_w = trace.power_w.data() + block.first;
    light = Eigen::Map<const Eigen::VectorXf>(light_w, static_cast<Eigen::Index>(n)).cast<double>();
    found[j - first] = {kernel->re.dot(light), kernel->im.dot(light)};
  }
  return found;
}

}  // namespace vildar
