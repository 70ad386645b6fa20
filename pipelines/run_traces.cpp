#include "pipelines/run_traces.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "capture/photodiode_csv.h"
#include "capture/photodiode_sound.h"
#include "condition/condition.h"
#include "condition/noise.h"
#include "core/error.h"
#include "core/text.h"

namespace vildar {
namespace {

void count_rejected(const PowerTrace& trace, const std::string& file, RunSummary& summary) {
  summary.rejected_samples[trace.photodiode_id] = trace.rejected;
  for (const auto& [reason, samples] : trace.rejected) {
    if (samples == 0) continue;
    summary.damaged = true;
    summary.warnings.push_back(file + ": " + std::to_string(samples) + " samples of " +
                               trace.photodiode_id + " left out: " + reason);
  }
  if (trace.switched_w > 0.0)
    summary.warnings.push_back(file +
                               ": light that was switched on and off before several "
                               "photodiodes at once was taken out of " +
                               trace.photodiode_id + ", up to " +
                               fixed_text(1e9 * trace.switched_w, 1) + " nW");
}

// One clock stamps all photodiodes of a file.
void warn_of_fall(const std::vector<PowerTrace>& traces, const std::string& file,
                  RunSummary& summary) {
  const auto fallen =
      std::ranges::find_if(traces, [](const PowerTrace& trace) { return trace.fall.has_value(); });
  if (fallen == traces.end()) return;
  summary.warnings.push_back(file + ": t_s goes from " + number_text(fallen->fall->before_s) +
                             " to " + number_text(fallen->fall->after_s) +
                             "; where the logger's clock was set back, split the file there");
}

/// Missing samples, like pictures that a recorder dropped, are counted; what is there is sound.
void count_gaps(const PowerTrace& trace, const std::string& file, RunSummary& summary) {
  constexpr double kGapPeriods = 2.5;
  std::int64_t gaps = 0;
  double longest_s = 0.0, longest_at_s = 0.0;
  for (std::size_t i = 1; i < trace.time_s.size(); ++i) {
    const double spacing_s = trace.time_s[i] - trace.time_s[i - 1];
    if (spacing_s <= kGapPeriods * trace.sample_period_s) continue;
    ++gaps;
    if (spacing_s <= longest_s) continue;
    longest_s = spacing_s;
    longest_at_s = trace.time_s[i - 1];
  }
  summary.counts["gaps_" + trace.photodiode_id] = gaps;
  if (gaps > 0)
    summary.warnings.push_back(
        file + ": " + std::to_string(gaps) + " gaps in " + trace.photodiode_id +
        ", the longest of " + fixed_text(longest_s, 3) +
        " s after t_s = " + number_text(longest_at_s) + "; nothing is assumed there" +
        (trace.rejected.empty() ? "" : " (samples that were left out may be among them)"));
}

// A photodiode that has no light to tell of must not stop the others.
void leave_out_dead(const std::string& file, std::vector<PowerTrace>& traces, RunSummary& summary) {
  constexpr std::size_t kFewest = 10;  // samples: fewer are told of as too few
  std::erase_if(traces, [&](const PowerTrace& trace) {
    const auto& power_w = trace.power_w;
    std::string fault;
    if (power_w.empty())
      fault = " has no sample that can be used";
    else if (power_w.size() >= kFewest &&
             std::adjacent_find(power_w.begin(), power_w.end(), std::not_equal_to<>()) ==
                 power_w.end())
      fault = " has the same value throughout";
    if (fault.empty()) return false;
    summary.damaged = true;
    summary.warnings.push_back(file + ": " + trace.photodiode_id + fault +
                               ", as of a dead or unplugged photodiode; it was left out, check its "
                               "cable and supply");
    return true;
  });
}

// The most that it receives above ambient, by means of 20 ms.
double brightest_w(const PowerTrace& trace) {
  constexpr double kBlock_s = 0.02, kWhole = 0.5;
  double most_w = 0.0;
  for (std::size_t from = 0, to = 0; from < trace.time_s.size(); from = to) {
    double sum_w = 0.0;
    for (; to < trace.time_s.size() && trace.time_s[to] < trace.time_s[from] + kBlock_s; ++to)
      sum_w += trace.power_w[to];
    const auto samples = static_cast<double>(to - from);
    if (samples * trace.sample_period_s > kWhole * kBlock_s)
      most_w = std::max(most_w, sum_w / samples - trace.ambient_w);
  }
  return most_w;
}

// One that goes on telling values, but none of the vehicles that the others see.
void warn_of_dark(const std::vector<PowerTrace>& traces, const Site& site, const std::string& file,
                  RunSummary& summary) {
  constexpr double kOfOthers = 0.01, kClearSigmas = 20.0;
  std::vector<double> lights_w;
  double most_w = 0.0;
  for (const PowerTrace& trace : traces) {
    const double light_w = brightest_w(trace);
    const double gain =
        site.photodiodes[static_cast<std::size_t>(trace.photodiode)].gain_ratio.mean;
    lights_w.push_back(light_w / gain);
    if (light_w > kClearSigmas * trace.noise_sigma_w) most_w = std::max(most_w, lights_w.back());
  }
  for (std::size_t k = 0; k < traces.size(); ++k)
    if (lights_w[k] < kOfOthers * most_w)
      summary.warnings.push_back(
          file + ": " + traces[k].photodiode_id +
          " receives less than a hundredth of what another does at most, for its gain_ratio; "
          "check its cable and supply, what covers it and where it looks");
}

TraceSummary summary_of(const PowerTrace& trace) {
  return {trace.photodiode_id,   trace.sample_period_s > 0.0 ? 1.0 / trace.sample_period_s : 0.0,
          trace.noise_sigma_w,   trace.ambient_w,
          trace.ambient_sigma_w, trace.drift_w,
          trace.flicker_w,       trace.mains_hz,
          trace.pulsing,         trace.switched_w};
}

void warn_of_other_mains(const PowerTrace& trace, const Site& site, const std::string& file,
                         RunSummary& summary) {
  constexpr double kSameGrid_hz = 1.0;
  if (trace.mains_hz == 0.0 || std::abs(trace.mains_hz - site.mains_hz) < kSameGrid_hz) return;
  summary.warnings.push_back(file + ": " + trace.photodiode_id + " flickers with mains of " +
                             fixed_text(trace.mains_hz, 2) + " Hz, but mains_hz is " +
                             number_text(site.mains_hz) + " in " + site.file.string() +
                             "; what it shows was taken out, correct the site file");
}

/// Samples a second that traces are made for. Far fewer show no vehicle: what they seem to hold
/// would be rows of nothing.
void judge_rate(const PowerTrace& trace, const std::string& file, RunSummary& summary) {
  constexpr double kLowest_hz = 100.0, kHighest_hz = 1e5, kRounding = 0.02, kFewest_hz = 20.0;
  if (!(trace.sample_period_s > 0.0)) return;
  const double rate_hz = 1.0 / trace.sample_period_s;
  if (rate_hz > kLowest_hz * (1.0 - kRounding) && rate_hz < kHighest_hz * (1.0 + kRounding)) return;
  const std::string fault = file + ": " + trace.photodiode_id + " has " +
                            fixed_text(rate_hz, rate_hz < 1.0 ? 5 : 1) +
                            " samples a second by its stamps, and 100 to 100000 are asked for; "
                            "check that t_s is in seconds";
  if (rate_hz < kFewest_hz) throw InputError(fault);
  summary.warnings.push_back(fault);
}

/// What swings back after each vehicle is no light: it passes for other vehicles.
void judge_coupling(const PowerTrace& trace, const std::string& file) {
  if (trace.blocks_constant_light)
    throw InputError(file + ": " + trace.photodiode_id +
                     " falls below its dark level after vehicles and creeps back, as of an "
                     "amplifier or a sound card that blocks constant light; record the light "
                     "itself (coupled for direct current)");
}

/// A transimpedance amplifier turns the sign of the light.
void warn_of_inversion(const PowerTrace& trace, const std::string& file, RunSummary& summary) {
  constexpr double kFew = 0.001, kClear = 20.0, kFarMore = 5.0;
  std::vector<double> power_w(trace.power_w.begin(), trace.power_w.end());
  if (power_w.empty()) return;
  const double usual_w = quantile_of(power_w, 0.5);
  const double down_w = usual_w - quantile_of(power_w, kFew);
  const double up_w = quantile_of(power_w, 1.0 - kFew) - usual_w;
  if (down_w < kClear * trace.noise_sigma_w || down_w < kFarMore * up_w) return;
  summary.warnings.push_back(file + ": " + trace.photodiode_id + " falls by " +
                             fixed_text(down_w / std::max(up_w, trace.noise_sigma_w), 0) +
                             " times as much as it rises, where vehicles make it rise; if its "
                             "amplifier inverts, record it with the other sign");
}

/// What the site file leaves open of photodiodes that are used together.
void warn_of_open_site(const std::vector<PowerTrace>& traces, const Site& site,
                       const std::string& file, RunSummary& summary) {
  const auto key_of = [](const PowerTrace& trace, const char* key) {
    return "photodiodes[" + std::to_string(trace.photodiode) + "]." + key;
  };
  const auto of = [&](const PowerTrace& trace) -> const PhotodiodeSite& {
    return site.photodiodes[static_cast<std::size_t>(trace.photodiode)];
  };
  for (const PhotodiodeSite& diode : site.photodiodes)
    if (std::ranges::find(traces, diode.id, &PowerTrace::photodiode_id) == traces.end())
      summary.warnings.push_back(file + ": has no column of photodiode " + diode.id + ", which " +
                                 site.file.string() + " describes; measuring without it");
  if (site.channel && site.channel->gain_db && !site.channel->lamp_power_told)
    summary.warnings.push_back(
        site.file.string() +
        ": channel.lamp_power_w is not given, which scales what gain_db says; taken as 1 W. Speeds "
        "from the photodiode's level alone are off by as much as that is: measure it");
  if (site.channel && !site.channel->beam.empty() && traces.size() == 1)
    summary.warnings.push_back(
        site.file.string() +
        ": channel.beam: no method of a single photodiode follows a beam; give channel.gain_db and "
        "path_loss_exponent for power_slope_photodiode, curved_angle_photodiode and ml_photodiode");
  for (const PowerTrace& trace : traces) {
    const PhotodiodeSite& diode = of(trace);
    if (traces.size() > 1 && !diode.gain_ratio_told)
      summary.warnings.push_back(
          site.file.string() + ": " + key_of(trace, "gain_ratio") + " is not given; taken as " +
          number_text(diode.gain_ratio.mean) + " +- " + number_text(diode.gain_ratio.std) +
          ", which widens the speeds; measure it, or learn it with `vildar calibrate photodiode`");
    if (diode.time_offset_s.mean != of(traces.front()).time_offset_s.mean)
      summary.warnings.push_back(site.file.string() + ": " + key_of(trace, "time_offset_s") +
                                 " is not that of " + key_of(traces.front(), "time_offset_s") +
                                 ", but the photodiodes of one trace have one clock; give both "
                                 "the same");
  }
}

}  // namespace

std::vector<PowerTrace> read_traces(const RunOptions& options, const Site& site,
                                    RunSummary& summary) {
  if (!options.photodiode) return {};
  const std::string file = options.photodiode->string();
  try {
    summary.inputs.push_back(describe_input("photodiode", *options.photodiode));
    PhotodiodeRecording recording =
        is_sound_file(*options.photodiode)
            ? read_photodiode_sound(*options.photodiode, site.photodiodes)
            : read_photodiode_csv(*options.photodiode);
    summary.warnings.insert(summary.warnings.end(), recording.warnings.begin(),
                            recording.warnings.end());
    summary.damaged |= recording.damaged;
    summary.counts["samples_read"] = recording.rows_read;
    if (!recording.rejected.empty())
      summary.rejected_samples["unreadable_rows"] = recording.rejected;
    std::vector<PowerTrace> traces = condition(std::move(recording), site);
    warn_of_fall(traces, file, summary);
    std::size_t most_samples = 0;
    bool in_order = true;
    for (const PowerTrace& trace : traces) {
      summary.counts["samples_used_" + trace.photodiode_id] =
          static_cast<std::int64_t>(trace.time_s.size());
      count_rejected(trace, file, summary);
      count_gaps(trace, file, summary);
      most_samples = std::max(most_samples, trace.time_s.size());
      in_order &= !trace.fall;
    }
    if (most_samples < 2)
      throw InputError(file + ": " + std::to_string(most_samples) + " of " +
                       std::to_string(summary.counts["samples_read"]) +
                       " samples can be used, and a speed needs many" +
                       (in_order ? "" : ", for t_s goes back from row to row") +
                       "; record the trace again");
    warn_of_open_site(traces, site, file, summary);
    leave_out_dead(file, traces, summary);
    warn_of_dark(traces, site, file, summary);
    for (const PowerTrace& trace : traces) {
      judge_rate(trace, file, summary);
      judge_coupling(trace, file);
      warn_of_inversion(trace, file, summary);
    }
    for (const PowerTrace& trace : traces) {
      summary.traces.push_back(summary_of(trace));
      warn_of_other_mains(trace, site, file, summary);
    }
    return traces;
  } catch (const InputError& error) {
    std::string fault = error.what();
    if (!fault.starts_with(file)) fault = file + ": " + fault;
    if (!options.clip) throw InputError(fault);
    summary.damaged = true;
    summary.warnings.push_back(fault + "; measuring with the camera alone");
    return {};
  }
}

void note_overlap(const RunOptions& options, const Site& site,
                  const std::vector<PowerTrace>& traces, double clip_end_s, RunSummary& summary) {
  constexpr double kSigmas = 4.0;
  for (const PowerTrace& trace : traces) {
    if (trace.time_s.empty()) continue;
    const auto index = static_cast<std::size_t>(trace.photodiode);
    const Uncertain& offset_s = site.photodiodes[index].time_offset_s;
    const double from_s = trace.time_s.front() + offset_s.mean;
    const double to_s = trace.time_s.back() + offset_s.mean;
    if (from_s - kSigmas * offset_s.std <= clip_end_s && to_s + kSigmas * offset_s.std >= 0.0)
      continue;
    summary.damaged = true;
    summary.warnings.push_back(
        options.photodiode->string() + ": " + trace.photodiode_id + " runs from " +
        fixed_text(from_s, 3) + " to " + fixed_text(to_s, 3) +
        " s of the clip's time, the clip from 0 to " + fixed_text(clip_end_s, 3) +
        " s: nothing in common, so it was not used; name the trace of this clip, or correct "
        "photodiodes[" +
        std::to_string(index) + "].time_offset_s in " + options.site.string());
  }
}

}  // namespace vildar
