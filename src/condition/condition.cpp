#include "condition/condition.h"

#include <algorithm>
#include <utility>

#include "condition/clean_samples.h"
#include "condition/common_steps.h"
#include "condition/coupling.h"
#include "condition/drift.h"
#include "condition/flashes.h"
#include "condition/flicker.h"
#include "condition/negative_samples.h"
#include "condition/noise.h"
#include "condition/pulsing_lamps.h"
#include "condition/spikes.h"
#include "core/error.h"

namespace vildar {
namespace {

std::size_t photodiode_named(const std::string& id, std::size_t channels, const Site& site) {
  if (site.photodiodes.empty())
    throw InputError(
        site.file.string() +
        ": has no photodiode, but a photodiode trace was given; describe it under photodiodes:");
  if (id.empty() && channels == 1) return 0;
  std::string known;
  for (std::size_t i = 0; i < site.photodiodes.size(); ++i) {
    if (site.photodiodes[i].id == id) return i;
    known += (i == 0 ? "" : ", ") + site.photodiodes[i].id;
  }
  throw InputError("the trace's photodiode \"" + id + "\" is not in " + site.file.string() +
                   ", which has " + known + "; rename the column or the id");
}

double needed(const std::optional<double>& factor, const char* key, const char* use,
              std::size_t photodiode, const Site& site) {
  if (factor) return *factor;
  throw InputError(site.file.string() + ": photodiodes[" + std::to_string(photodiode) + "]." + key +
                   " is missing, and the trace needs it to turn " + use +
                   "; add it, or record power_w");
}

/// What one unit of the recording is in watts.
double watts_per_unit(PowerQuantity quantity, bool shares, std::size_t index, const Site& site) {
  const PhotodiodeSite& photodiode = site.photodiodes[index];
  if (quantity == PowerQuantity::power_w) return 1.0;
  double amperes = 1.0;
  if (quantity != PowerQuantity::current_a) {
    double volts = 1.0;
    if (quantity == PowerQuantity::counts) {
      const std::optional<double>& scale = photodiode.volts_per_count || !shares
                                               ? photodiode.volts_per_count
                                               : photodiode.full_scale_v;
      volts = needed(scale, "volts_per_count", "counts into volts", index, site);
    }
    amperes = volts / needed(photodiode.transimpedance_v_per_a, "transimpedance_v_per_a",
                             "volts into amperes", index, site);
  }
  return amperes / needed(photodiode.responsivity_a_per_w, "responsivity_a_per_w",
                          "amperes into watts", index, site);
}

}  // namespace

std::vector<PowerTrace> condition(PhotodiodeRecording recording, const Site& site) {
  std::vector<PowerTrace> traces;
  const std::size_t channels = recording.ids.size();
  for (std::size_t channel = 0; channel < channels; ++channel) {
    const std::size_t index = photodiode_named(recording.ids[channel], channels, site);
    const double unit_w = watts_per_unit(recording.quantity, recording.shares, index, site);
    const bool last = channel + 1 == channels;
    CleanSamples clean = clean_samples(last ? std::move(recording.time_s) : recording.time_s,
                                       std::move(recording.values[channel]), recording.quantity,
                                       site.photodiodes[index]);
    PowerTrace trace;
    trace.photodiode_id = site.photodiodes[index].id;
    trace.photodiode = static_cast<int>(index);
    trace.time_s = std::move(clean.time_s);
    trace.power_w = std::move(clean.values);
    trace.rejected = std::move(clean.rejected);
    trace.clipped = std::move(clean.clipped);
    trace.fall = clean.fall;
    if (unit_w != 1.0)
      for (float& power_w : trace.power_w) power_w = static_cast<float>(power_w * unit_w);
    set_noise(trace);
    trace.blocks_constant_light = blocks_constant_light(trace);
    if (const std::int64_t negative = drop_negative(trace); negative > 0) {
      trace.rejected["negative"] = negative;
      set_noise(trace);
    }
    even_out_pulses(trace, site.mains_hz);
    const bool as_recorded = trace.pulsing.empty();  // else there is less noise between samples
    if (const std::int64_t spikes = drop_spikes(trace); spikes > 0) {
      trace.rejected["spike"] = spikes;
      if (as_recorded) set_noise(trace);
    }
    if (const std::int64_t flashes = drop_flashes(trace); flashes > 0) {
      trace.rejected["flash"] = flashes;
      if (as_recorded) set_noise(trace);
    }
    const bool hidden = trace.rounding_sigma_w > 0.0;  // and stays so, though a wave lies over it
    const double between_pulses_w = trace.flicker_w;
    remove_flicker(trace, site.mains_hz);
    trace.flicker_w = std::max(trace.flicker_w, between_pulses_w);
    if (trace.flicker_w > 0.0 && !hidden && as_recorded) set_noise(trace);
    traces.push_back(std::move(trace));
  }
  std::ranges::sort(traces, {}, &PowerTrace::photodiode);
  std::vector<Metres> along;
  for (const PowerTrace& trace : traces)
    along.emplace_back(
        site.photodiodes[static_cast<std::size_t>(trace.photodiode)].position_m[0].mean);
  remove_common_steps(traces, along);
  for (PowerTrace& trace : traces) {
    set_ambient(trace);
    remove_drift(trace);
  }
  return traces;
}

}  // namespace vildar
