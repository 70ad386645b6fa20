#include "pipelines/run_pipeline.h"

#include <algorithm>
#include <array>
#include <ctime>

#include "config/site_file.h"
#include "core/error.h"
#include "core/quantity.h"
#include "core/text.h"
#include "estimate/site_doubts.h"
#include "optics/ies_file.h"
#include "pipelines/interrupt.h"
#include "pipelines/own_turns.h"
#include "pipelines/run_annotate.h"
#include "pipelines/run_clip.h"
#include "pipelines/run_passes.h"
#include "pipelines/run_traces.h"
#include "pipelines/stage_timer.h"
#include "pipelines/version.h"
#include "sink/csv_tables.h"

namespace vildar {
namespace {

namespace fs = std::filesystem;

Problem usage(const std::string& file, const std::string& fault, const std::string& remedy) {
  return {file, 0, "", fault, remedy};
}

constexpr std::array kOutputs{"speeds.csv",  "methods.csv", "tracks.csv",   "blobs.csv",
                              "report.html", "run.json",    "annotated.mp4"};

std::vector<std::pair<std::string, fs::path>> inputs_of(const RunOptions& options,
                                                        const Site& site) {
  std::vector<std::pair<std::string, fs::path>> inputs{{"site", options.site}};
  if (site.ego && !site.ego->trace_path.empty()) inputs.emplace_back("ego", site.ego->trace_path);
  if (site.channel && site.channel->beam_is_file()) inputs.emplace_back("beam", site.channel->beam);
  if (options.clip) inputs.emplace_back("clip", *options.clip);
  if (options.photodiode) inputs.emplace_back("photodiode", *options.photodiode);
  return inputs;
}

/// A run replaces or removes every file of an earlier one, and must not take an input for such.
void check_outputs_are_no_inputs(const RunOptions& options, const Site& site,
                                 std::vector<Problem>& problems) {
  for (const auto& [role, input] : inputs_of(options, site))
    for (const char* name : kOutputs)
      if (std::error_code error; fs::equivalent(input, options.out / name, error))
        problems.push_back(usage(input.string(),
                                 "is the " + role + " to read, and the run would write " +
                                     (options.out / name).string() + " in its place",
                                 "choose another --out"));
}

void check_usage(const RunOptions& options, const Site& site) {
  std::vector<Problem> problems;
  check_outputs_are_no_inputs(options, site, problems);
  const std::string site_file = options.site.string();
  if (!options.clip && !options.photodiode)
    problems.push_back(usage("vildar run", "neither a clip nor a photodiode trace was given",
                             "name a clip, --photodiode TRACE, or both"));
  if (options.clip && !site.camera)
    problems.push_back(usage(site_file, "there is a clip but the site has no camera",
                             "add a `camera:` section, or leave the clip out"));
  if (options.photodiode && site.photodiodes.empty())
    problems.push_back(usage(site_file,
                             "there is a photodiode trace but the site has no photodiode",
                             "add a `photodiodes:` section, or leave --photodiode out"));
  if (!options.clip && (options.annotate || options.blobs))
    problems.push_back(usage("vildar run", "--annotate and --blobs need a clip", "name a clip"));
  for (const std::string& problem : options.clip_options.problems())
    problems.push_back(usage("vildar run", problem, "see `vildar run --help`"));
  if (!problems.empty()) throw ConfigError(std::move(problems));
}

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm broken_down{};
  ::gmtime_r(&now, &broken_down);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &broken_down);
  return text.data();
}

std::map<std::string, std::string> options_in_force(const RunOptions& options) {
  const ClipOptions& clip = options.clip_options;
  return {
      {"frame_rate_override_hz", clip.frame_rate_hz ? number_text(*clip.frame_rate_hz) : "none"},
      {"decoder_threads", std::to_string(clip.decoder_threads)},
      {"fast", clip.skip_loop_filter ? "true" : "false"}};
}

void append(std::vector<std::string>& to, const std::vector<std::string>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

void note_missing_frames(const RunOptions& options, const FrameSteps::Tally& steps,
                         RunSummary& summary) {
  const std::int64_t missing = steps.unfilled();
  summary.counts["frames_missing_unstamped"] = missing;
  if (missing < FrameSteps::kFewestMissing) return;
  summary.warnings.push_back(
      options.clip->string() + ": lamps jump by whole frames' ways: " + std::to_string(missing) +
      " frames are missing beside " + std::to_string(steps.judged) +
      " that were judged, and the time stamps go on as if none were, so speeds seem too high; keep "
      "the recorder's own time stamps (variable frame rate), or record with less load");
}

void note_repeated_frames(const RunOptions& options, const ClipMeasurement& measurement,
                          RunSummary& summary) {
  constexpr double kShareToTellOf = 0.1;
  const std::int64_t repeated = std::ssize(measurement.repeated_frames);
  const std::int64_t read = measurement.counts.frames_read;
  summary.counts["frames_repeated"] = repeated;
  summary.counts["frames_retimed"] = measurement.retiming ? read - repeated : 0;
  if (measurement.retiming) {
    const Retiming& retiming = *measurement.retiming;
    const std::string when = "measured at the even times of " + fixed_text(retiming.rate_hz(), 2) +
                             " frames/s; keep the recorder's own frames and time stamps";
    summary.warnings.push_back(
        options.clip->string() + ": " +
        (retiming.change.repeats()
             ? std::to_string(repeated) + " of " + std::to_string(read) +
                   " frames show the one before again, regularly, as where a clip was given a "
                   "higher rate; left out, and the others " +
                   when
             : "lamps jump regularly, as where frames were left out to give a clip a lower rate; " +
                   when));
    return;
  }
  if (repeated == 0 || static_cast<double>(repeated) < kShareToTellOf * static_cast<double>(read))
    return;
  summary.warnings.push_back(
      options.clip->string() + ": " + std::to_string(repeated) + " of " + std::to_string(read) +
      " frames show the one before again, as where a clip was given a higher "
      "rate; left out; keep the recorder's own frames and time stamps");
}

void doubt_own_speed(const RunOptions& options, const EgoSite& ego, RunSummary& summary) {
  constexpr double kFastRoad_mps = 50.0;
  const auto fastest = std::ranges::max_element(ego.trace, {}, &EgoSample::speed_mps);
  const bool traced = fastest != ego.trace.end();
  const double fastest_mps = traced ? fastest->speed_mps : ego.speed_mps.mean;
  const std::string where =
      traced ? ego.trace_path.string() + ": at " + fixed_text(fastest->time_s, 1) + " s"
             : options.site.string() + ": ego.speed_mps:";
  if (fastest_mps > kFastRoad_mps)
    summary.warnings.push_back(where + " an own speed of " + fixed_text(fastest_mps, 1) +
                               " m/s is " + fixed_text(kmh_from_mps(fastest_mps), 0) +
                               " km/h; ego speeds are in metres per second (km/h divided by 3.6)");
}

// Before a camera that stands lights seldom move but on the road: a camera of which that is told
// drives, or looks elsewhere.
void doubt_moving_lights(const RunOptions& options, const Site& site,
                         const ClipMeasurement& measurement, RunSummary& summary) {
  constexpr std::int64_t kFewest = 2, kMany = 5;
  constexpr std::int64_t kOnABody = 2;  // side and roof lamps of a vehicle that was measured
  const std::int64_t lights = measurement.track_counts.moving_lights;
  const std::int64_t vehicles = std::ssize(measurement.vehicles);
  const std::int64_t measured = std::ranges::count_if(
      measurement.vehicles, [](const VehicleResult& vehicle) { return !vehicle.withheld; });
  const std::int64_t explained = vehicles + kOnABody * measured;
  if (site.ego || lights < (vehicles == 0 ? kFewest : std::max(kMany, explained + 1))) return;
  summary.warnings.push_back(
      options.site.string() + ": " + std::to_string(lights) +
      " lights moved through the picture for a second or more that are no vehicles on the road "
      "stated, beside " +
      std::to_string(vehicles) +
      " that have a row: a camera that drives needs ego, its own motion, one that is held by hand "
      "a "
      "tripod; else check pitch_deg (negative: down), yaw_deg and position_m, and the road");
}

void note_glare(const RunOptions& options, const ClipMeasurement& measurement,
                RunSummary& summary) {
  const std::int64_t lights = measurement.track_counts.saturated;
  summary.counts["saturated"] = lights;
  if (lights == 0) return;
  summary.warnings.push_back(
      options.clip->string() + ": " + std::to_string(lights) +
      (lights == 1 ? " light is" : " lights are") +
      " one clipped area, wider than a lamp, all the while: of vehicles that glare so no lamp can "
      "be told from the other, and they have no row; expose for a shorter time or with less gain");
}

void note_black_pictures(const RunOptions& options, const ClipMeasurement& measurement,
                         RunSummary& summary) {
  const auto& black = measurement.black_pictures.longest();
  summary.counts["frames_black"] = black ? black->frames : 0;
  if (!black) return;
  summary.damaged = true;
  const bool to_end = black->to_s >= measurement.last_frame_s;
  summary.warnings.push_back(
      options.clip->string() + ": the picture is black from " + fixed_text(black->from_s, 2) +
      (to_end ? " s on, to the clip's end" : " to " + fixed_text(black->to_s, 2) + " s") +
      ", lights and noise and all, as of a camera or a cable that fails: nothing is measured "
      "there");
}

void describe_clip(const RunOptions& options, const Site& site, const ClipMeasurement& measurement,
                   RunSummary& summary) {
  const ClipInfo& info = measurement.info;
  summary.clip = ClipSummary{
      info.container, info.codec,        info.pixel_format,          info.width_px,
      info.height_px, info.rotation_deg, info.nominal_frame_rate_hz, measurement.last_frame_s};
  summary.options["colour_range"] = info.colour_range;
  const ClipCounts& counts = measurement.counts;
  summary.counts["frames_read"] = counts.frames_read;
  summary.counts["frames_damaged"] = counts.frames_damaged;
  summary.counts["frames_after_damage"] = counts.frames_after_damage;
  summary.counts["frames_dropped"] = counts.frames_dropped;
  summary.counts["frames_of_other_size"] = counts.frames_of_other_size;
  summary.counts["packets_damaged"] = counts.packets_damaged;
  summary.counts["time_stamps_repaired"] = counts.time_stamps_repaired;
  summary.counts["blobs"] = measurement.blobs;
  summary.counts["static_lights"] = measurement.track_counts.static_lights;
  summary.counts["reflections"] = measurement.track_counts.reflections;
  summary.counts["short_tracks"] = measurement.track_counts.short_tracks;
  summary.counts["beside_the_lanes"] = measurement.track_counts.off_road;
  summary.counts["undecided"] = measurement.track_counts.undecided;
  summary.counts["moving_lights"] = measurement.track_counts.moving_lights;
  note_repeated_frames(options, measurement, summary);
  note_missing_frames(options, measurement.frame_steps, summary);
  summary.timings_s.insert(measurement.timings_s.begin(), measurement.timings_s.end());
  append(summary.warnings, counts.warnings);
  if (site.camera->psf && !info.lossless)
    summary.warnings.push_back(
        options.clip->string() + ": " + info.codec +
        " reshapes the rims of lamps: the light of those that clip is known to some twentieth, and "
        "no speed is taken from how it changes; record with a lossless codec (FFV1) for that");
  if (site.ego && site.road.kind == RoadKind::curved &&
      (site.road.straight_m.mean > 0.0 || site.road.straight_m.std > 0.0))
    summary.warnings.push_back(
        options.site.string() +
        ": road.straight_m beside ego: the bend is taken to stay that far ahead of the moving "
        "camera all along the clip; cut the clip to the bend and write straight_m: 0");
  if (site.ego) doubt_own_speed(options, *site.ego, summary);
  doubt_moving_lights(options, site, measurement, summary);
  note_glare(options, measurement, summary);
  note_black_pictures(options, measurement, summary);
  append(summary.warnings, turns_off_the_road(site, measurement.last_frame_s));
  summary.damaged |= counts.damaged();
}

// A covered or dead camera sees not one light in any frame, while the photodiodes do.
bool camera_is_dark(const ClipMeasurement& measurement) {
  return measurement.blobs == 0 && measurement.vehicles.empty();
}

// What the photodiodes saw beside the camera, or in its place.
void add_passes(const RunOptions& options, const Site& site, const std::vector<PowerTrace>& traces,
                ClipMeasurement& measurement, RunSummary& summary) {
  note_overlap(options, site, traces, measurement.last_frame_s, summary);
  if (traces.empty()) return;
  if (!camera_is_dark(measurement)) {
    add_unseen_passes(site, traces, {measurement.last_frame_s, measurement.counts.truncated},
                      measurement.vehicles, summary);
    return;
  }
  measurement.vehicles = measure_passes(site, traces);
  if (measurement.vehicles.empty()) return;
  summary.damaged = true;
  summary.warnings.push_back(
      options.clip->string() + ": no light in any of " +
      std::to_string(measurement.counts.frames_read) +
      " frames, but the photodiodes saw vehicles; measuring with them alone, "
      "check the camera's lens cover and exposure");
}

// A folder holds one run: what this one does not write must not stand beside its speeds.
void remove_of_earlier_run(const fs::path& file) {
  std::error_code error;
  fs::remove(file, error);
  if (error)
    throw OutputError(file.string() + ": of an earlier run, cannot be removed: " + error.message() +
                      "; remove it, or choose another folder");
}

void collect_vehicle_warnings(const std::vector<VehicleResult>& vehicles, RunSummary& summary) {
  for (const VehicleResult& vehicle : vehicles)
    for (const std::string& warning : vehicle.warnings)
      summary.warnings.push_back("vehicle " + std::to_string(vehicle.track_id) + ": " + warning);
}

struct MeasuredClip {
  ClipMeasurement measurement;
  TracksWriter tracks;
  std::optional<BlobsWriter> blobs;
};

MeasuredClip measured(ClipSource& clip, const std::optional<Retiming>& retiming,
                      const RunOptions& options, const Site& site,
                      const std::vector<PowerTrace>& traces) {
  MeasuredClip made{{}, TracksWriter(options.out / "tracks.csv"), {}};
  if (options.blobs) made.blobs.emplace(options.out / "blobs.csv");
  made.measurement = measure_clip(clip, retiming, options, site, traces, made.tracks,
                                  made.blobs ? &*made.blobs : nullptr);
  return made;
}

// A clip that turns out to be woven of two fields, or to have been given another rate, is read once
// more: by one field, with the times at which its frames were taken.
MeasuredClip measured_as_taken(ClipSource& clip, const RunOptions& options, const Site& site,
                               const std::vector<PowerTrace>& traces) {
  std::map<std::string, double> spent_s;
  std::optional<Retiming> retiming;
  ClipOptions as_taken = options.clip_options;
  {
    MeasuredClip made = measured(clip, std::nullopt, options, site, traces);
    retiming = made.measurement.retiming;
    as_taken.one_field = made.measurement.woven;
    if (!as_taken.one_field && !retiming) return made;
    spent_s = std::move(made.measurement.timings_s);
  }
  ClipSource again_from(*options.clip, as_taken);
  MeasuredClip again = measured(again_from, retiming, options, site, traces);
  again.measurement.retiming = retiming;
  for (const auto& [stage, time_s] : spent_s) again.measurement.timings_s[stage] += time_s;
  return again;
}

// A lens shows a wide pixel's width as fewer pixels: fy / fx is the pixels' width over their
// height.
std::string doubt_of_pixels(const CameraSite& camera, const ClipInfo& clip) {
  constexpr double kAlike = 0.01, kSquare = 0.001;
  const double declared = clip.pixel_aspect.value_or(1.0);
  const double stated = camera.focal_px[1] / camera.focal_px[0];
  if (std::abs(declared - 1.0) < kSquare || std::abs(std::log(declared / stated)) < kAlike)
    return "";
  return ": camera.focal_px: fy / fx is " + fixed_text(stated, 3) +
         ", but the clip declares pixels " + fixed_text(declared, 3) +
         " times as wide as high, which makes it that; speeds are wrong by as much where the clip "
         "is right: give both focal lengths as measured in its pixels";
}

}  // namespace

RunOutcome run_pipeline(const RunOptions& options) {
  const InterruptScope interruptible;
  const Site site = load_site(options.site);
  check_usage(options, site);
  if (site.channel && site.channel->beam_is_file()) (void)read_ies(site.channel->beam);

  RunOutcome outcome;
  RunSummary& summary = outcome.summary;
  summary.version = kVersion;
  summary.started = utc_now();
  summary.settings_yaml = effective_site_yaml(site);
  summary.speed_limit_mps = site.road.speed_limit_mps;
  summary.options = options_in_force(options);
  for (const auto& [role, file] : inputs_of(options, site))
    if (role != "photodiode") summary.inputs.push_back(describe_input(role, file));

  std::vector<TrackPlot> plots;
  std::vector<AtomicFile> files;
  StageTimer timer(summary.timings_s);
  if (options.clip) {
    ClipSource clip(*options.clip, options.clip_options);
    check_site_fits_clip(site, clip.info().width_px, clip.info().height_px);
    if (auto doubt = doubt_of_pixels(*site.camera, clip.info()); !doubt.empty())
      summary.warnings.push_back(options.site.string() + doubt);
    const std::vector<PowerTrace> traces = read_traces(options, site, summary);
    if (options.photodiode) timer.charge("read");
    auto [measurement, tracks, blobs] = measured_as_taken(clip, options, site, traces);
    describe_clip(options, site, measurement, summary);
    add_passes(options, site, traces, measurement, summary);
    if (options.annotate) files.push_back(annotate_clip(options, measurement));
    outcome.vehicles = std::move(measurement.vehicles);
    plots = std::move(measurement.plots);
    files.push_back(std::move(tracks).finish());
    if (blobs) files.push_back(std::move(*blobs).finish());
  } else {
    const std::vector<PowerTrace> traces = read_traces(options, site, summary);
    timer.charge("read");
    outcome.vehicles = measure_passes(site, traces);
    timer.charge("estimate");
    files.push_back(TracksWriter(options.out / "tracks.csv").finish());
  }

  if (options.clip)
    for (const std::string& doubt : site_doubts(outcome.vehicles, site.road))
      summary.warnings.push_back(options.site.string() + ": " + doubt);
  collect_vehicle_warnings(outcome.vehicles, summary);
  files.push_back(write_speeds(options.out / "speeds.csv", outcome.vehicles));
  files.push_back(write_methods(options.out / "methods.csv", outcome.vehicles));
  files.push_back(write_report(options.out / "report.html", summary, outcome.vehicles, plots));
  files.push_back(write_run_json(options.out / "run.json", summary, outcome.vehicles));
  if (!options.annotate) remove_of_earlier_run(options.out / "annotated.mp4");
  if (!options.blobs) remove_of_earlier_run(options.out / "blobs.csv");
  for (AtomicFile& file : files) file.commit();
  return outcome;
}

}  // namespace vildar
