#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/atomic_file.h"
#include "types/power.h"
#include "types/result.h"

namespace vildar {

/// A file that a run has read.
struct InputFile {
  std::string role;  ///< clip, photodiode, site, ego, beam
  std::filesystem::path path;
  std::uintmax_t size_bytes = 0;
  std::string sha256;  ///< 64 lower-case hexadecimal digits
};

/// Size and SHA-256 of a regular file, read as a stream. Throws InputError where it cannot be read.
InputFile describe_input(const std::string& role, const std::filesystem::path& path);

/// The clip as its source describes it.
struct ClipSummary {
  std::string container;  ///< e.g. mp4
  std::string codec;      ///< e.g. h264
  std::string pixel_format;
  int width_px = 0;  ///< of the upright picture
  int height_px = 0;
  int rotation_deg = 0;
  double nominal_frame_rate_hz = 0.0;
  double duration_s = 0.0;  ///< last presentation time less the first
};

/// The light on one photodiode, vehicles apart.
struct TraceSummary {
  std::string photodiode;
  double sample_rate_hz = 0.0;
  double noise_w = 0.0;  ///< standard deviation of one sample, white part
  double ambient_w = 0.0;
  double ambient_std_w = 0.0;
  double drift_w = 0.0;    ///< range of the ambient's slow changes
  double flicker_w = 0.0;  ///< amplitude
  double mains_hz = 0.0;   ///< as the flicker shows; 0: it shows none
  std::vector<PulsingLight> pulsing;
  double switched_w = 0.0;  ///< largest jump of lights switched on and off
};

/// What a run was given, how it was set and what it met; becomes run.json and the head of the
/// report.
struct RunSummary {
  std::string version;  ///< of the program
  std::string started;  ///< ISO 8601, UTC; may be empty
  std::vector<InputFile> inputs;
  std::optional<ClipSummary> clip;             ///< absent without a camera
  std::vector<TraceSummary> traces;            ///< of the photodiodes that could be used
  std::optional<double> speed_limit_mps;       ///< of the site, drawn in the report
  std::string settings_yaml;                   ///< the effective site file
  std::map<std::string, std::string> options;  ///< command-line options in force
  std::map<std::string, std::int64_t> counts;  ///< frames_read, frames_damaged, samples_read, ...
  /// Photodiode id -> reason -> samples left out.
  std::map<std::string, std::map<std::string, std::int64_t>> rejected_samples;
  std::map<std::string, double> timings_s;  ///< stage -> seconds of CPU time of the process
  std::vector<std::string> warnings;        ///< each names file, place, fault and remedy
  bool damaged = false;                     ///< an input was damaged and the rest of it was used
};

/// The content of run.json: the summary and every vehicle with its methods. Absent numbers are left
/// out; bytes that are not UTF-8 become U+FFFD.
std::string run_json_text(const RunSummary& summary, std::span<const VehicleResult> vehicles);

/// run.json, finished and not yet committed; throws OutputError.
[[nodiscard]] AtomicFile write_run_json(const std::filesystem::path& path,
                                        const RunSummary& summary,
                                        std::span<const VehicleResult> vehicles);

}  // namespace vildar
