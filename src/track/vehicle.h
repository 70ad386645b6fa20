#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "track/lamp.h"
#include "track/light_scale.h"
#include "track/tracker.h"

namespace vildar {

/// Recent mean of a pair's chi2 above which it does not look like one vehicle.
inline constexpr double kMostMeanChi2 = 11.0;

/// Two lamps that travel together. A side whose lamp was lost keeps its records and may get
/// another.
struct Vehicle {
  Lamp* left = nullptr;
  Lamp* right = nullptr;
  std::vector<LampRecord> past_left, past_right;
  LampKind kind = LampKind::headlamp;
  int both_seen = 0;  ///< frames
  double chi2 = 0.0;  ///< of the pair, recent mean
  double inverse_depth_per_m = 0.0;
  double width_per_depth = 0.0;
  /// Last vector from the left lamp to the right one.
  Eigen::Vector2d from_left_px = Eigen::Vector2d::Zero();
  std::int64_t last_both = 0;  ///< frame in which both lamps were last seen
  CameraTime last_both_time;
  std::int64_t last_good = 0;  ///< frame in which the pair last looked like one vehicle
  std::int64_t asked = -1;     ///< frame in which it was last compared with lost vehicles
  int second_on_body = 0;      ///< frames as the lesser pair of a vehicle with a better one
  int in_row = 0;              ///< frames with a light between both lamps, seen from high above
  int looks = 0;               ///< frames in which either lamp was seen
  int images = 0;              ///< of these, as the image on the road of another pair
  std::optional<std::int64_t> cut_after;  ///< last frame before it was no longer one vehicle
  bool came_apart = false;                ///< that is why it was cut
  bool lamps_go_on = false;               ///< a lamp of it began anew there
  /// Last frame in which the one light seen of it was another vehicle's; told once it has gone.
  std::optional<std::int64_t> last_as_another;
  bool ambiguous = false;
  bool drove_out = false;      ///< of the image, with the last of its lamps
  bool told_strength = false;  ///< has been entered in the LightScale

  Lamp* partner_of(const Lamp* lamp) const { return lamp == left ? right : left; }
};

/// What was seen of one side, in order of frames, up to where the vehicle was cut. What a lamp was
/// while the side was another's is not the vehicle's.
std::vector<LampRecord> records_of(const Vehicle& vehicle, const Lamp* lamp,
                                   const std::vector<LampRecord>& past);

/// When the last of its records was, of the lamps that it has lost.
CameraTime last_seen(const Vehicle& lost);

/// ln(flux x depth^2) of a lamp now, with the depth of its vehicle where it has one.
double strength_of(const Lamp& lamp);

/// Of two pairs on one body the brighter one is the vehicle's, and of equal ones the lower: roof
/// and side lights, and their own reflections, do not outshine the lamps. But fog lamps, close
/// below the headlamps, may, and of equal ones at one height the one known first is taken. `other`
/// needs both its lamps.
bool outshines(const Lamp& left, const Lamp& right, const Vehicle& other, bool known_first);

/// A vehicle that has gone and was coming apart when both its lamps were last seen is cut where
/// they last looked like one vehicle's. One whose last look was good, and that yet fits badly,
/// stays.
void cut_where_it_came_apart(Vehicle& gone);

/// By less in the image a light may have moved though it stands: what it shines through shivers,
/// coding shifts it.
inline constexpr double kMoved_px = 8.0;

/// Before a camera that stands: whether a light moved for a second or more, by 50 mrad or more.
bool moves_plainly(const Lamp& light, const RoadView& view);

enum class Verdict { vehicle, short_track, static_light, reflection, off_road, undecided };

/// What a vehicle, or a light without a partner, turns out to be now that it is gone. The
/// track is written only with Verdict::vehicle.
Verdict judge_vehicle(const Vehicle& vehicle, const RoadView& view, const TrackOptions& options,
                      const LightScale& lights, VehicleTrack& track);
Verdict judge_single(const Lamp& lamp, const RoadView& view, const TrackOptions& options,
                     const LightScale& lights, VehicleTrack& track);

}  // namespace vildar
