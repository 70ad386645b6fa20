#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "evaluate/folders.h"
#include "evaluate/speed_statistics.h"
#include "evaluate/tracking_metrics.h"

namespace vildar {

/// What the true bearings depend on besides the truth.
struct EvaluateOptions {
  Eigen::Vector2d camera_xy_m = Eigen::Vector2d::Zero();  ///< in the road frame
  /// First row to last row; with a rolling shutter the bearing of a lamp holds at its row's time.
  double rolling_shutter_s = 0.0;
  int image_height_px = 1;
};

/// What became of one vehicle, true or false.
struct VehicleScore {
  enum class Outcome {
    measured,     ///< matched, with a speed
    withheld,     ///< matched, without a speed
    missed,       ///< in view, no track shows it
    not_in_view,  ///< never visible to the sensors: counts in no share
    false_speed,  ///< a speed where truth has no vehicle
    duplicate,    ///< a second speed for a vehicle that another track was matched to
  };
  Outcome outcome = Outcome::missed;
  std::string vehicle_id;  ///< empty for a false speed
  std::string track_id;    ///< empty where missed
  std::string lane;        ///< as truth names it
  std::string withheld;    ///< the reason
  std::optional<StatedSpeed> stated;
  /// At the run's own t_ref_s; absent where truth does not reach there.
  std::optional<double> true_mps;
  bool wrong_direction = false;
  /// Root mean square over the frames in which both are known.
  std::optional<double> azimuth_rms_rad, range_rms_m;

  std::optional<SpeedPair> pair() const;
};

struct MethodScore {
  std::size_t measured = 0;
  std::map<std::string, std::size_t> withheld;  ///< by reason
  std::size_t false_speeds = 0;                 ///< for tracks that are matched to no vehicle
  SpeedStatistics speed;
};

struct Evaluation {
  std::vector<VehicleScore> vehicles;  ///< those of the truth in its order, then the false ones
  bool matched_by_image = false;
  std::size_t in_view = 0, not_in_view = 0, matched = 0, measured = 0, missed = 0;
  std::size_t false_speeds = 0;  ///< duplicates among them
  std::size_t duplicates = 0, wrong_direction = 0;
  std::size_t without_truth = 0;                ///< measured, but truth has no speed at that time
  std::map<std::string, std::size_t> withheld;  ///< by reason
  SpeedStatistics speed;
  std::optional<double> azimuth_rms_rad, range_rms_m;
  std::map<std::string, MethodScore> methods;
  std::optional<TrackingScores> tracking;  ///< absent without pixels or with other frame rates
  std::vector<std::string> notes;
};

Evaluation evaluate(const std::vector<TruthVehicle>& truth, const RunFolder& run,
                    const EvaluateOptions& options = {});

std::string_view name_of(VehicleScore::Outcome outcome);

}  // namespace vildar
