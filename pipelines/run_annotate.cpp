#include "pipelines/run_annotate.h"

#include <algorithm>
#include <deque>

#include "core/quantity.h"
#include "core/text.h"
#include "pipelines/interrupt.h"
#include "pipelines/progress.h"
#include "sink/annotator.h"

namespace vildar {
namespace {

constexpr std::size_t kTrailPoints = 40;

std::string label_of(const VehicleResult& vehicle) {
  const std::string id = "#" + std::to_string(vehicle.track_id) + " ";
  if (vehicle.withheld) return id + std::string(name_of(*vehicle.withheld));
  return id + fixed_text(kmh_from_mps(vehicle.speed.speed_mps), 1) + " +-" +
         fixed_text(kmh_from_mps(vehicle.speed.std_mps), 1) + " km/h";
}

}  // namespace

AtomicFile annotate_clip(const RunOptions& options, const ClipMeasurement& measurement) {
  ClipSource clip(*options.clip, options.clip_options);
  Annotator annotator(options.out / "annotated.mp4", measurement.info.width_px,
                      measurement.info.height_px, measurement.info.nominal_frame_rate_hz);
  std::map<int, const VehicleResult*> vehicles;
  for (const VehicleResult& vehicle : measurement.vehicles) vehicles[vehicle.track_id] = &vehicle;

  std::map<int, std::deque<Eigen::Vector2d>> trails;
  auto next = measurement.sightings.begin();
  std::vector<AnnotationBox> boxes;  // kept where a frame shows the one before again
  Progress progress("annotating", measurement.counts.frames_read, "frames");
  while (const std::optional<Frame> frame = clip.next()) {
    throw_if_interrupted();
    if (!std::ranges::binary_search(measurement.repeated_frames, frame->index)) boxes.clear();
    for (; next != measurement.sightings.end() && next->frame <= frame->index; ++next) {
      auto& trail = trails[next->track_id];
      trail.push_back(next->middle_px.cast<double>());
      if (trail.size() > kTrailPoints) trail.pop_front();
      if (next->frame < frame->index) continue;
      const VehicleResult& vehicle = *vehicles.at(next->track_id);
      boxes.push_back({vehicle.track_id,
                       vehicle.direction,
                       next->left,
                       next->right,
                       label_of(vehicle),
                       {trail.begin(), trail.end()}});
    }
    std::erase_if(trails, [&](const auto& entry) {
      return vehicles.at(entry.first)->t_last_s < seconds_of(frame->time);
    });
    annotator.add(*frame, boxes);
    progress.update(frame->index + 1);
  }
  return annotator.finish();
}

}  // namespace vildar
