#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/error.h"
#include "synth/photodiode_trace.h"

namespace vildar {
namespace {

constexpr double kElementaryCharge_c = 1.602176634e-19;
constexpr double kBoltzmann_j_per_k = 1.380649e-23;

double clip_time_s(const Scenario& scenario, double diode_time_s) {
  return diode_time_s * (1.0 + 1e-6 * scenario.photodiode.clock_drift_ppm) +
         scenario.site.photodiodes.front().time_offset_s.mean;
}

// How many times within a sample the light is looked at, so that the pole is resolved.
int inner_steps(const PhotodiodeScene& scene) {
  constexpr double kMost = 1000.0;
  if (!scene.bandwidth_hz) return 1;
  return static_cast<int>(
      std::clamp(std::ceil(32.0 * *scene.bandwidth_hz / scene.rate_hz), 1.0, kMost));
}

}  // namespace

// One photodiode with its amplifier, in watts of light at the input.
class TraceRenderer::FrontEnd {
 public:
  FrontEnd(const Scenario& scenario, const PhotodiodeSite& photodiode)
      : scenario_(scenario),
        photodiode_(photodiode),
        steps_(inner_steps(scenario.photodiode)),
        step_s_(1.0 / (scenario.photodiode.rate_hz * steps_)) {
    const PhotodiodeScene& scene = scenario.photodiode;
    if (scene.bandwidth_hz) {
      keep_ = std::exp(-2.0 * kPi * *scene.bandwidth_hz * step_s_);
      into_step_ = 0.5;
    }
    output_w_ = light_w(scenario, photodiode, clip_time_s(scenario, -step_s_), 0.0);
  }

  // The output at sample `index`, without the white noise of the converter.
  double sample_w(std::size_t index, Random& random) {
    for (int step = steps_ - 1; step >= 0; --step) {
      const double time_s =
          static_cast<double>(index) / scenario_.photodiode.rate_hz - (step + into_step_) * step_s_;
      double input_w = light_w(scenario_, photodiode_, clip_time_s(scenario_, time_s),
                               2.0 * into_step_ * step_s_);
      const double variance_w2 = variance_of_step_w2(input_w);
      if (variance_w2 > 0.0) input_w += random.normal(0.0, std::sqrt(variance_w2));
      output_w_ = keep_ * output_w_ + (1.0 - keep_) * input_w;
    }
    return output_w_;
  }

 private:
  // White noise of the current, one-sided density 2 q I + 4 k T / R, in a band of half the rate of
  // the inner steps.
  double variance_of_step_w2(double input_w) const {
    const PhotodiodeScene& scene = scenario_.photodiode;
    if (!photodiode_.responsivity_a_per_w) return 0.0;
    const double a_per_w = *photodiode_.responsivity_a_per_w;
    double density = 0.0;
    if (scene.shot_noise) density += 2.0 * kElementaryCharge_c * std::max(0.0, input_w) * a_per_w;
    if (scene.temperature_k && photodiode_.transimpedance_v_per_a)
      density +=
          4.0 * kBoltzmann_j_per_k * *scene.temperature_k / *photodiode_.transimpedance_v_per_a;
    return density * 0.5 / step_s_ / (a_per_w * a_per_w);
  }

  const Scenario& scenario_;
  const PhotodiodeSite& photodiode_;
  int steps_;
  double step_s_;
  double keep_ = 0.0;
  double into_step_ = 0.0;  ///< where a step looks at the light, back from its end
  double output_w_ = 0.0;
};

namespace {

double converted_w(const Scenario& scenario, const PhotodiodeSite& photodiode, double power_w) {
  const PhotodiodeScene& scene = scenario.photodiode;
  if (!scene.adc_bits) return power_w;
  const double most = std::exp2(*scene.adc_bits) - 1.0;
  const double step_w = converter_step_w(scene, photodiode);
  return step_w * std::clamp(std::round(power_w / step_w), 0.0, most);
}

bool in_a_gap(const PhotodiodeScene& scene, double time_s) {
  return std::any_of(scene.gaps.begin(), scene.gaps.end(), [&](const TraceGap& gap) {
    return time_s >= gap.from_s && time_s < gap.to_s;
  });
}

double written_value(const PhotodiodeScene& scene, const PhotodiodeSite& photodiode,
                     double power_w) {
  switch (scene.quantity) {
    case PowerQuantity::power_w: return power_w;
    case PowerQuantity::current_a: return power_w * photodiode.responsivity_a_per_w.value();
    case PowerQuantity::voltage_v:
      return power_w * photodiode.responsivity_a_per_w.value() *
             photodiode.transimpedance_v_per_a.value();
    case PowerQuantity::counts: return std::round(power_w / converter_step_w(scene, photodiode));
  }
  return power_w;
}

const char* column_of(PowerQuantity quantity) {
  switch (quantity) {
    case PowerQuantity::power_w: return "power_w";
    case PowerQuantity::current_a: return "current_a";
    case PowerQuantity::voltage_v: return "voltage_v";
    case PowerQuantity::counts: return "counts";
  }
  return "";
}

}  // namespace

double converter_step_w(const PhotodiodeScene& scene, const PhotodiodeSite& photodiode) {
  if (scene.quantity == PowerQuantity::counts)
    return photodiode.volts_per_count.value() /
           (photodiode.responsivity_a_per_w.value() * photodiode.transimpedance_v_per_a.value());
  return scene.full_scale_w.value() / (std::exp2(scene.adc_bits.value()) - 1.0);
}

TraceRenderer::TraceRenderer(const Scenario& scenario)
    : scenario_(scenario),
      noise_w_(scenario.photodiode.noise_w),
      random_(scenario.seed),
      samples_(static_cast<std::size_t>(
          std::llround(scenario.duration_s * scenario.photodiode.rate_hz))) {
  const std::vector<PhotodiodeSite>& photodiodes = scenario.site.photodiodes;
  if (scenario.photodiode.snr_db) {
    const double first_s = clip_time_s(scenario, 0.0);
    const std::vector<VehicleState> states = states_at(scenario, first_s);
    double first_w = 0.0;
    for (std::size_t i = 0; i < states.size(); ++i)
      first_w += vehicle_power_w(scenario, states, i, photodiodes.front(), first_s);
    if (!(first_w > 0.0))
      throw ConfigError(
          {{scenario.file.string(), 0, "photodiode.snr_db",
            "no vehicle lights the first photodiode at t = 0, so the ratio has no meaning",
            "give noise_w instead, or start a vehicle in its field of view"}});
    noise_w_ = first_w * std::pow(10.0, -*scenario.photodiode.snr_db / 20.0);
  }
  for (const PhotodiodeSite& photodiode : photodiodes)
    front_ends_.emplace_back(scenario, photodiode);
  sample_.power_w.resize(photodiodes.size());
}

TraceRenderer::~TraceRenderer() = default;

const TraceRenderer::Sample* TraceRenderer::next() {
  while (index_ < samples_) {
    sample_.time_s = static_cast<double>(index_) / scenario_.photodiode.rate_hz;
    for (std::size_t p = 0; p < front_ends_.size(); ++p) {
      double power_w = front_ends_[p].sample_w(index_, random_);
      if (noise_w_ > 0.0) power_w += random_.normal(0.0, noise_w_);
      sample_.power_w[p] = converted_w(scenario_, scenario_.site.photodiodes[p], power_w);
    }
    ++index_;
    if (!in_a_gap(scenario_.photodiode, sample_.time_s)) return &sample_;
  }
  return nullptr;
}

RenderedTrace render_trace(const Scenario& scenario) {
  TraceRenderer renderer(scenario);
  RenderedTrace trace;
  trace.noise_w = renderer.noise_w();
  trace.power_w.resize(scenario.site.photodiodes.size());
  while (const TraceRenderer::Sample* sample = renderer.next()) {
    trace.time_s.push_back(sample->time_s);
    for (std::size_t p = 0; p < trace.power_w.size(); ++p)
      trace.power_w[p].push_back(sample->power_w[p]);
  }
  return trace;
}

std::string trace_csv_header(const Scenario& scenario) {
  std::string text = "t_s";
  const std::vector<PhotodiodeSite>& photodiodes = scenario.site.photodiodes;
  for (const PhotodiodeSite& photodiode : photodiodes)
    text += "," + (photodiodes.size() > 1 ? photodiode.id + "_" : std::string()) +
            column_of(scenario.photodiode.quantity);
  return text + '\n';
}

std::string trace_csv_line(const Scenario& scenario, const TraceRenderer::Sample& sample) {
  // Enough decimals of time to tell neighbours apart at 100 kHz and odd rates.
  char cell[64];
  std::snprintf(cell, sizeof cell, "%.9g", sample.time_s);
  std::string line = cell;
  for (std::size_t p = 0; p < sample.power_w.size(); ++p) {
    std::snprintf(
        cell, sizeof cell, ",%.*g", scenario.photodiode.digits,
        written_value(scenario.photodiode, scenario.site.photodiodes[p], sample.power_w[p]));
    line += cell;
  }
  return line + '\n';
}

}  // namespace vildar
