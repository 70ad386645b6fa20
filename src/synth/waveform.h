#pragma once

namespace vildar {

/// How a lamp's light varies about its mean, which is 1: steady, a sine (mains), or pulses (LED).
class Waveform {
 public:
  Waveform() = default;
  /// 1 + depth sin(2 pi (frequency t + phase)); depth in [0, 1], frequency > 0.
  static Waveform sine(double frequency_hz, double depth, double phase);
  /// 1 / duty while the fraction of (frequency t + phase) lies below duty, else 0; duty in (0, 1].
  static Waveform pulses(double frequency_hz, double duty, double phase);

  double at(double time_s) const;
  /// Mean over an interval of positive length.
  double mean(double from_s, double to_s) const;
  /// Of the variation; 0 for a steady light.
  double frequency_hz() const { return frequency_hz_; }

 private:
  enum class Kind { steady, sine, pulses };
  double integral_cycles(double cycles) const;

  Kind kind_ = Kind::steady;
  double frequency_hz_ = 0.0;
  double level_ = 0.0;  ///< depth, or duty
  double phase_ = 0.0;
};

}  // namespace vildar
