#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/clip_source.h"
#include "estimate/frame_steps.h"
#include "pipelines/black_pictures.h"
#include "pipelines/retiming.h"
#include "pipelines/run_pipeline.h"
#include "pipelines/vehicle_power.h"
#include "sink/csv_tables.h"
#include "sink/report.h"
#include "track/tracker.h"
#include "types/power.h"
#include "types/site.h"

namespace vildar {

/// Where a vehicle stood in a frame, kept for the annotated video only.
struct AnnotatedSighting {
  std::int64_t frame = 0;
  int track_id = 0;
  std::optional<PixelBox> left, right;
  Eigen::Vector2f middle_px = Eigen::Vector2f::Zero();
};

struct ClipMeasurement {
  ClipInfo info;
  ClipCounts counts;
  TrackCounts track_counts;
  FrameSteps::Tally frame_steps;
  BlackPictures black_pictures;
  std::vector<std::int64_t> repeated_frames;  ///< that show the frame before again
  bool woven = false;                ///< the pictures are of two fields, though they do not say so
  std::optional<Retiming> retiming;  ///< that they were given another rate
  std::int64_t blobs = 0;
  double last_frame_s = 0.0;
  std::vector<VehicleResult> vehicles;  ///< by track id
  std::vector<TrackPlot> plots;
  std::vector<AnnotatedSighting> sightings;  ///< by frame; empty unless the run annotates
  std::map<std::string, double> timings_s;   ///< CPU time of this process by stage
};

/// Reads the clip once: finds lamps, follows vehicles, measures each as soon as its track has ended
/// (with photodiodes: as soon as no vehicle that was in view with it is still followed), gives of
/// one that was seen twice the better speed, and writes them once none that was in view with them
/// is still followed. Frames are taken to be of their stamps' times, or those of `retiming`.
ClipMeasurement measure_clip(ClipSource& clip, const std::optional<Retiming>& retiming,
                             const RunOptions& options, const Site& site,
                             std::span<const PowerTrace> traces, TracksWriter& tracks,
                             BlobsWriter* blobs);

}  // namespace vildar
