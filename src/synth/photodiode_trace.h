#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/random.h"
#include "synth/motion.h"
#include "synth/scenario.h"

namespace vildar {

/// Mean power (over the waveform of its lamps) that one photodiode receives from one vehicle.
///
/// With the power law of the site's channel: K times lamp power, D from the photodiode to the
/// vehicle's place at lamp height, cos(theta) = R / D. With a beam, the channel's or the vehicle's
/// own: the sum over the lamps of I cos(incidence) area / D^2 / efficacy. Both are dimmed by the
/// air. Zero where the vehicle is outside the field of view, its lamps look the other way, or
/// another body hides it. Throws std::invalid_argument where the site lacks the channel.
/// `states` are those of states_at(scenario, time_s).
double vehicle_power_w(const Scenario& scenario, const std::vector<VehicleState>& states,
                       std::size_t vehicle, const PhotodiodeSite& photodiode, double time_s);

/// Mean power (over its flicker) that one photodiode receives from a street lamp: I cos(incidence)
/// area / D^2 / efficacy, dimmed by the air. Zero outside the field of view, behind a vehicle, and
/// for a photodiode without an area_m2.
double street_lamp_power_w(const Scenario& scenario, const std::vector<VehicleState>& states,
                           std::size_t lamp, const PhotodiodeSite& photodiode, double time_s);

/// All light on a photodiode at one instant of clip time: vehicles with their waveforms, street
/// lamps and the ambient light with their flicker. Where `window_s` > 0, waveforms are averaged
/// over that time about the instant.
double light_w(const Scenario& scenario, const PhotodiodeSite& photodiode, double time_s,
               double window_s);

/// Light of one step of the converter. Needs adc_bits and full_scale_w, or for counts what turns
/// them into watts; throws std::bad_optional_access without.
double converter_step_w(const PhotodiodeScene& scene, const PhotodiodeSite& photodiode);

/// What the photodiodes of a scenario record, in watts of light, sample by sample.
class TraceRenderer {
 public:
  /// `scenario` must outlive it. Throws ConfigError where a noise in decibels is asked for and no
  /// vehicle is received at the first sample of the first photodiode.
  explicit TraceRenderer(const Scenario& scenario);
  ~TraceRenderer();

  struct Sample {
    double time_s = 0.0;          ///< photodiode clock
    std::vector<double> power_w;  ///< by photodiode
  };
  /// The next sample that is not lost in a gap; nothing after the last one. It is overwritten by
  /// the next call.
  const Sample* next();
  /// Standard deviation of one sample, white part.
  double noise_w() const { return noise_w_; }

 private:
  class FrontEnd;
  const Scenario& scenario_;
  double noise_w_ = 0.0;
  std::vector<FrontEnd> front_ends_;
  Random random_;
  std::size_t index_ = 0, samples_ = 0;
  Sample sample_;
};

/// A whole trace.
struct RenderedTrace {
  std::vector<double> time_s;                ///< photodiode clock
  std::vector<std::vector<double>> power_w;  ///< [photodiode][sample]
  double noise_w = 0.0;                      ///< standard deviation of one sample, white part
};
/// Throws as TraceRenderer does.
RenderedTrace render_trace(const Scenario& scenario);

/// Header line and one line of a sample of the contract's CSV (section 3), ends of line included.
std::string trace_csv_header(const Scenario& scenario);
std::string trace_csv_line(const Scenario& scenario, const TraceRenderer::Sample& sample);

}  // namespace vildar
