#include "synth/waveform.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

namespace vildar {
namespace {

double mean_by_sums(const Waveform& wave, double from_s, double to_s) {
  constexpr int kSteps = 200'000;
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) sum += wave.at(from_s + (to_s - from_s) * (i + 0.5) / kSteps);
  return sum / kSteps;
}

TEST(Waveform, MeansAreThoseOfItsValues) {
  constexpr double kTolerance = 1e-4;  // pulses are cut at up to four steps of 200000
  for (const Waveform& wave :
       {Waveform(), Waveform::sine(100.0, 0.3, 0.2), Waveform::pulses(217.0, 0.3, 0.85)})
    for (const double from_s : {-0.013, 0.0, 0.4012})
      for (const double span_s : {0.0007, 0.004, 0.03})
        EXPECT_NEAR(wave.mean(from_s, from_s + span_s), mean_by_sums(wave, from_s, from_s + span_s),
                    kTolerance);
}

TEST(Waveform, WholeCyclesAverageToOne) {
  EXPECT_NEAR(Waveform::sine(100.0, 1.0, 0.4).mean(0.003, 0.053), 1.0, 1e-12);
  EXPECT_NEAR(Waveform::pulses(200.0, 0.1, 0.7).mean(0.0011, 0.0261), 1.0, 1e-12);
}

TEST(Waveform, PulsesShorterThanTheExposureCanBeMissed) {
  const Waveform wave = Waveform::pulses(100.0, 0.2, 0.0);
  EXPECT_EQ(wave.at(0.001), 5.0);
  EXPECT_EQ(wave.at(0.003), 0.0);
  EXPECT_EQ(wave.mean(0.003, 0.005), 0.0);
}

TEST(Waveform, RefusesWhatItCannotBe) {
  EXPECT_THROW(Waveform::sine(0.0, 0.5, 0.0), std::invalid_argument);
  EXPECT_THROW(Waveform::sine(50.0, 1.5, 0.0), std::invalid_argument);
  EXPECT_THROW(Waveform::pulses(50.0, 0.0, 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace vildar
