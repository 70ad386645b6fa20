#include "pipelines/run_clip.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "core/text.h"
#include "detect/combing.h"
#include "detect/detector.h"
#include "estimate/frame_steps.h"
#include "estimate/one_place.h"
#include "estimate/site_doubts.h"
#include "estimate/steady_view.h"
#include "estimate/two_lone_lamps.h"
#include "estimate/vehicle.h"
#include "optics/response.h"
#include "pipelines/interrupt.h"
#include "pipelines/progress.h"
#include "pipelines/run_passes.h"
#include "pipelines/stage_timer.h"
#include "track/repeated_frames.h"
#include "track/road_view.h"

namespace vildar {
namespace {

constexpr std::size_t kPlotPoints = 200;
constexpr std::size_t kTogether = 20;  // vehicles that are asked together about the site file
constexpr double kForever = std::numeric_limits<double>::infinity();

ClipInterval interval_of(const VehicleTrack& track) {
  return {seconds_of(track.sightings.front().time), seconds_of(track.sightings.back().time)};
}

TrackPlot plot_of(const VehicleEstimate& estimate) {
  TrackPlot plot;
  plot.track_id = estimate.result.track_id;
  const std::size_t step = estimate.rows.size() / kPlotPoints + 1;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < estimate.rows.size(); i += step) {
    const TrackRow& row = estimate.rows[i];
    plot.t_s.push_back(row.time_s);
    plot.range_m.push_back(row.range_m.value_or(kNone));
    plot.speed_mps.push_back(row.speed_mps.value_or(kNone));
    plot.azimuth_rad.push_back(row.bearing_rad ? row.bearing_rad->x() : kNone);
    plot.intensity.push_back(row.intensity);
  }
  return plot;
}

AnnotatedSighting annotated(int track_id, const VehicleSighting& sighting) {
  AnnotatedSighting note{sighting.frame, track_id, {}, {}, Eigen::Vector2f::Zero()};
  float lamps = 0.0F;
  for (const auto* lamp : {&sighting.left, &sighting.right}) {
    if (!*lamp) continue;
    (lamp == &sighting.left ? note.left : note.right) = (*lamp)->box;
    note.middle_px += (*lamp)->centre_px.cast<float>();
    lamps += 1.0F;
  }
  note.middle_px /= std::max(lamps, 1.0F);
  return note;
}

class Measuring {
 public:
  Measuring(const RunOptions& options, const Site& site, std::span<const PowerTrace> traces,
            TracksWriter& tracks, ClipMeasurement& measurement)
      : options_(options),
        site_(site),
        traces_(traces),
        passes_(traces.size() > 1 && !site.ego ? passes_of(traces) : std::vector<PowerPass>{}),
        tracks_(tracks),
        measurement_(measurement),
        measured_(RoadView(site).height_over_lamps_m(), RoadView(site).lamp_height_m()) {}

  void take(std::vector<VehicleTrack> ended, const Tracker& tracker) {
    for (VehicleTrack& track : ended) {
      track.id = ++last_id_;
      std::vector<std::int64_t> frames;
      for (const VehicleSighting& sighting : track.sightings) frames.push_back(sighting.frame);
      std::optional<SteadyView> steady = steady_view(track, tracker.turns_in(frames), site_);
      Ended one{std::move(track), std::move(steady)};
      note_light(one);
      waiting_.push_back(std::move(one));
    }
  }

  /// Measures the tracks beside which all is known that shone on the photodiodes. `live_since_s`:
  /// the first sighting of the oldest vehicle still followed, or now. Without photodiodes none has
  /// to wait. Writes those that were in view with none that is yet to be measured.
  void measure_before(double live_since_s) {
    const auto ready =
        std::stable_partition(waiting_.begin(), waiting_.end(), [&](const Ended& one) {
          return !traces_.empty() && !company_known(interval_of(one.track), live_since_s);
        });
    std::for_each(ready, waiting_.end(), [&](const Ended& one) { measure(one); });
    waiting_.erase(ready, waiting_.end());
    double needed_since_s = live_since_s;
    for (const Ended& one : waiting_)
      needed_since_s = std::min(needed_since_s, interval_of(one.track).from_s);
    std::erase_if(lit_, [&](const LitVehicle& lit) { return dark_since(lit, needed_since_s); });
    write_before(needed_since_s);
  }

  const FrameSteps& steps() const { return steps_; }

 private:
  /// A vehicle that ended, and as a camera at rest would have seen it where this one shakes.
  struct Ended {
    VehicleTrack track;
    std::optional<SteadyView> steady;
  };

  void note_light(const Ended& one) {
    if (traces_.empty() || one.track.beside_lanes_m) return;
    lit_.push_back(one.steady ? lit_vehicle(one.steady->track, one.steady->site)
                              : lit_vehicle(one.track, site_));
  }

  VehicleEstimate estimate_of(const Ended& one, std::span<const VehiclePower> power,
                              const std::optional<OwnPass>& pass) const {
    if (!one.steady) return estimate_vehicle(one.track, site_, power, pass);
    VehicleEstimate estimate = estimate_vehicle(one.steady->track, one.steady->site, power, pass);
    // The lights may have misled: a vehicle that is not explained so may be as it was seen.
    if (estimate.result.withheld) return estimate_vehicle(one.track, site_, power, pass);
    for (std::size_t i = 0; i < estimate.rows.size(); ++i)
      for (const auto lamp_of : {&VehicleSighting::left, &VehicleSighting::right}) {
        const auto& seen = one.track.sightings[i].*lamp_of;
        auto& shown = estimate.rows[i].sighting.*lamp_of;
        if (!seen || !shown) continue;
        shown->centre_px = seen->centre_px;  // where the image shows it
        shown->centre_sigma_px = seen->centre_sigma_px;
      }
    return estimate;
  }

  /// Of a pair whose lamps turn out to be of one vehicle each; the right one has a new id.
  std::optional<std::pair<Ended, Ended>> two_vehicles_of(const Ended& one,
                                                         const VehicleResult& found) {
    const bool steadied = one.steady.has_value();
    if (!two_lone_lamps(steadied ? one.steady->track : one.track, found,
                        steadied ? one.steady->site : site_))
      return std::nullopt;
    auto [left, right] = lamps_alone(one.track);
    std::pair<Ended, Ended> lamps{{std::move(left), {}}, {std::move(right), {}}};
    lamps.second.track.id = ++last_id_;
    if (!steadied) return lamps;
    auto [steady_left, steady_right] = lamps_alone(one.steady->track);
    steady_right.id = last_id_;
    lamps.first.steady = {std::move(steady_left), one.steady->site};
    lamps.second.steady = {std::move(steady_right), one.steady->site};
    return lamps;
  }

  void measure(const Ended& one) {
    const VehicleTrack& track = one.track;
    OfferedPower offered;
    const auto own = std::ranges::find(lit_, track.id, &LitVehicle::track_id);
    std::optional<OwnPass> pass;
    if (own != lit_.end() && !own->receding) {
      const auto index = static_cast<std::size_t>(own - lit_.begin());
      offered = offer_power(lit_, index, site_, traces_);
      if (auto found = own_pass(lit_, index, site_, traces_, passes_)) pass = {*found, traces_};
    }
    VehicleEstimate estimate = estimate_of(one, offered.power, pass);
    if (const auto lamps = two_vehicles_of(one, estimate.result)) {
      std::erase_if(lit_, [&](const LitVehicle& lit) { return lit.track_id == track.id; });
      for (const Ended* lamp : {&lamps->first, &lamps->second}) note_light(*lamp);
      for (const Ended* lamp : {&lamps->first, &lamps->second}) measure(*lamp);
      return;
    }
    steps_.add(one.steady ? one.steady->track : track);
    if (offered.unexplained)
      estimate.result.warnings.push_back(
          "the photodiodes receive light that none of the vehicles in view explains, so the power "
          "law gives no speed; check the camera's view, the channel and the photodiodes' clock "
          "(time_offset_s)");
    if (options_.annotate)
      for (const VehicleSighting& sighting : track.sightings)
        measurement_.sightings.push_back(annotated(track.id, sighting));
    measured_.add(std::move(estimate));
  }

  void withhold_where_frames_miss(VehicleEstimate& estimate) const {
    if (estimate.rows.empty()) return;
    const double share = steps_.missing_share(estimate.rows.front().sighting.frame,
                                              estimate.rows.back().sighting.frame);
    if (!bears_on(share, estimate.result)) return;
    withhold(estimate, Miss::frames_missing,
             {Method::geometry_camera, Method::fused, Method::power_slope_camera,
              Method::curved_angle_camera},
             "its lamps jump by whole frames' ways: some " +
                 fixed_text(100.0 * share / (1.0 + share), 0) +
                 " % of the frames are missing, and the time stamps go on as if none were");
  }

  void write_before(double time_s) {
    for (VehicleEstimate& estimate : measured_.take_before(time_s)) {
      withhold_where_frames_miss(estimate);
      kept_.push_back(std::move(estimate));
    }
    if (kept_.size() >= kTogether || time_s == kForever) write();
  }

  /// Where most vehicles contradict the site file, one that does not by chance moves as its road
  /// asks for, with a speed that its interval need not hold.
  void withhold_where_most_contradict() {
    constexpr double kWide = 0.1;  // relative sigma
    const auto earlier = std::span(measurement_.vehicles);
    const std::size_t before =
        std::min(earlier.size(), kTogether - std::min(kTogether, kept_.size()));
    std::vector<VehicleResult> together(earlier.end() - static_cast<std::ptrdiff_t>(before),
                                        earlier.end());
    for (const VehicleEstimate& estimate : kept_) together.push_back(estimate.result);
    const auto elsewhere = most_elsewhere(together);
    if (!elsewhere) return;
    for (VehicleEstimate& estimate : kept_) {
      const VehicleResult& result = estimate.result;
      if (result.withheld || !result.used_camera ||
          result.speed.std_mps > kWide * result.speed.speed_mps)
        continue;
      withhold(estimate, Miss::bad_fit, {Method::geometry_camera, Method::fused},
               std::to_string(elsewhere->count) + " of " + std::to_string(elsewhere->of) +
                   " vehicles in turn do not move as on the road stated, so that what this one "
                   "seems to do is in doubt, too");
    }
  }

  void write() {
    withhold_where_most_contradict();
    for (VehicleEstimate& estimate : kept_) {
      tracks_.add(estimate.rows);
      measurement_.plots.push_back(plot_of(estimate));
      measurement_.vehicles.push_back(std::move(estimate.result));
    }
    kept_.clear();
  }

  const RunOptions& options_;
  const Site& site_;
  std::span<const PowerTrace> traces_;
  std::vector<PowerPass> passes_;  ///< of two photodiodes or more
  TracksWriter& tracks_;
  ClipMeasurement& measurement_;
  std::vector<Ended> waiting_;
  int last_id_ = 0;  ///< of a vehicle
  MeasuredVehicles measured_;
  std::vector<VehicleEstimate> kept_;  ///< to be written
  FrameSteps steps_;
  std::vector<LitVehicle> lit_;
};

}  // namespace

ClipMeasurement measure_clip(ClipSource& clip, const std::optional<Retiming>& retiming,
                             const RunOptions& options, const Site& site,
                             std::span<const PowerTrace> traces, TracksWriter& tracks,
                             BlobsWriter* blobs) {
  ClipMeasurement measurement;
  DetectOptions detect;
  detect.lossy = !clip.info().lossless;
  Detector detector(detect, Response(*site.camera), site.camera->exposure_s, site.camera->psf);
  Tracker tracker(TrackOptions{}, site);
  RepeatedFrames repeated;
  Combing combing;
  Measuring measuring(options, site, traces, tracks, measurement);
  Progress progress("measuring", clip.info().frames_declared, "frames");
  StageTimer timer(measurement.timings_s);
  EvenStamps stamps;
  std::optional<CameraTime> taken;  // the last one that was measured
  while (std::optional<Frame> frame = clip.next()) {
    throw_if_interrupted();
    timer.charge("decode");
    measurement.last_frame_s = seconds_of(frame->time);
    stamps.add(frame->index, frame->time);
    if (frame->damaged) continue;  // what it shows may never have been; a gap does no harm
    if (retiming) {
      frame->time = retiming->time_of(frame->index);
      if (taken && frame->time <= *taken) {
        measurement.repeated_frames.push_back(frame->index);
        continue;
      }
    }
    BlobFrame found = detector.detect(*frame);
    combing.add(*frame, found.blobs);
    timer.charge("detect");
    if (repeated.repeats(found)) {
      measurement.repeated_frames.push_back(found.frame);
      continue;
    }
    taken = frame->time;
    std::vector<VehicleTrack> ended = tracker.update(found);
    measurement.blobs += static_cast<std::int64_t>(found.blobs.size());
    measurement.black_pictures.add(*frame, !found.blobs.empty());
    timer.charge("track");
    if (!ended.empty()) {
      measuring.take(std::move(ended), tracker);
      const auto live_since = tracker.live_since();
      measuring.measure_before(live_since ? seconds_of(*live_since) : seconds_of(frame->time));
      timer.charge("estimate");
    }
    if (blobs != nullptr) {
      blobs->add(found);
      timer.charge("write");
    }
    progress.update(frame->index + 1);
  }
  timer.charge("decode");
  measuring.take(tracker.finish(), tracker);
  measuring.measure_before(kForever);
  timer.charge("estimate");

  measurement.woven = combing.told();
  measurement.retiming =
      retiming_of(stamps, measurement.repeated_frames, measuring.steps().after_one_missing());
  measurement.info = clip.info();
  measurement.counts = clip.counts();
  measurement.track_counts = tracker.counts();
  measurement.frame_steps = measuring.steps().all();
  const auto by_id = [](const auto& a, const auto& b) { return a.track_id < b.track_id; };
  std::sort(measurement.vehicles.begin(), measurement.vehicles.end(), by_id);
  std::sort(measurement.plots.begin(), measurement.plots.end(), by_id);
  std::stable_sort(measurement.sightings.begin(), measurement.sightings.end(),
                   [](const auto& a, const auto& b) { return a.frame < b.frame; });
  return measurement;
}

}  // namespace vildar
