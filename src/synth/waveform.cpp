#include "synth/waveform.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/quantity.h"

namespace vildar {

Waveform Waveform::sine(double frequency_hz, double depth, double phase) {
  if (!(frequency_hz > 0.0) || !(depth >= 0.0 && depth <= 1.0))
    throw std::invalid_argument("Waveform: frequency must be > 0 and depth in [0, 1]");
  Waveform wave;
  wave.kind_ = Kind::sine;
  wave.frequency_hz_ = frequency_hz;
  wave.level_ = depth;
  wave.phase_ = phase;
  return wave;
}

Waveform Waveform::pulses(double frequency_hz, double duty, double phase) {
  if (!(frequency_hz > 0.0) || !(duty > 0.0 && duty <= 1.0))
    throw std::invalid_argument("Waveform: frequency must be > 0 and duty in (0, 1]");
  Waveform wave;
  wave.kind_ = Kind::pulses;
  wave.frequency_hz_ = frequency_hz;
  wave.level_ = duty;
  wave.phase_ = phase;
  return wave;
}

double Waveform::at(double time_s) const {
  const double cycles = frequency_hz_ * time_s + phase_;
  switch (kind_) {
    case Kind::steady: return 1.0;
    case Kind::sine: return 1.0 + level_ * std::sin(2.0 * kPi * cycles);
    case Kind::pulses: return cycles - std::floor(cycles) < level_ ? 1.0 / level_ : 0.0;
  }
  return 1.0;
}

double Waveform::integral_cycles(double cycles) const {
  if (kind_ == Kind::sine) return cycles - level_ * std::cos(2.0 * kPi * cycles) / (2.0 * kPi);
  const double whole = std::floor(cycles);
  return whole + std::min(1.0, (cycles - whole) / level_);
}

double Waveform::mean(double from_s, double to_s) const {
  if (kind_ == Kind::steady) return 1.0;
  const double first = frequency_hz_ * from_s + phase_, last = frequency_hz_ * to_s + phase_;
  return (integral_cycles(last) - integral_cycles(first)) / (last - first);
}

}  // namespace vildar
