#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "track/road_view.h"
#include "types/blob.h"
#include "types/vehicle_track.h"

namespace vildar {

struct Vehicle;

/// A blob as the tracker sees it.
struct Spot {
  const Blob* blob = nullptr;
  Eigen::Vector2d at_px;  ///< see RoadView
  double sigma_px = 1.0;  ///< of the blob as a mark to follow, which grows with its outline
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  ///< of the lamp, in pixels of the image
  Eigen::Vector2d centre_sigma_px = Eigen::Vector2d::Ones();
  bool streak = false;       ///< the drawn-out image on the road of a lamp above it
  bool with_streak = false;  ///< a lamp run together with such an image
  bool casts_image = false;  ///< such an image hangs below it, or is one blob with it
};

/// One sighting of a lamp, kept until its vehicle is reported.
struct LampRecord {
  std::int64_t frame = 0;
  CameraTime time;
  LampSighting sighting;
  Eigen::Vector2d at_px;
  double tail_log_odds = 0.0;        ///< of its colour, see tail_lamp_log_odds
  double faint_tail_log_odds = 0.0;  ///< see faint_tail_lamp_log_odds
  /// Half the pair's separation where the blob held both lamps of the vehicle; 0 elsewhere.
  double merged_px = 0.0;
  /// Distance to the lamp of another vehicle that the blob held as well, as far as known; 0
  /// elsewhere.
  double beside_px = 0.0;
  bool streak = false;       ///< see Spot
  bool casts_image = false;  ///< see Spot
};

/// Share of recent looks at which something held; the first looks count fully.
class RunningShare {
 public:
  void add(bool held, int memory) {
    ever_held_ += held;
    ++ever_looks_;
    looks_ = looks_ < memory ? looks_ + 1 : memory;
    share_ += ((held ? 1.0 : 0.0) - share_) / looks_;
  }
  double share() const { return share_; }
  int looks() const { return looks_; }
  /// Of all looks.
  double share_of_all() const { return ever_looks_ > 0 ? ever_held_ / ever_looks_ : 0.0; }

 private:
  double share_ = 0.0, ever_held_ = 0.0, ever_looks_ = 0.0;
  int looks_ = 0;
};

/// A light followed through the image: place and velocity in undistorted pixels, with the looming
/// of a point that moves along the road.
class Lamp {
 public:
  Lamp(const Spot& spot, const LampPlace& place, std::int64_t frame, CameraTime time,
       const RoadView& view);

  /// Moves the state on by dt_s > 0. Before a camera that sways or drives it may be turned as late
  /// innovations say.
  void predict(double dt_s, const RoadView& view, bool turns = false);
  /// The whole image moved by `shift_px` within dt_s. Where that goes on frame after frame it is
  /// movement of the lamps after all, so a share of it goes into the velocity.
  void shift(const Eigen::Vector2d& shift_px, double dt_s);
  /// Squared Mahalanobis distance of a spot, and the log determinant of its covariance; none where
  /// the distance is not below the gate.
  struct Distance {
    double chi2, log_det;
  };
  std::optional<Distance> distance_within(const Spot& spot, double gate_chi2) const;
  void update(const Spot& spot, std::int64_t frame, CameraTime time);
  /// As above where the blob holds the whole pair and this lamp stands `off_px` from its middle.
  void update_merged(const Spot& spot, const Eigen::Vector2d& off_px, std::int64_t frame,
                     CameraTime time);
  /// Follows the partner through a frame in which this lamp was not seen.
  void carry(const Eigen::Vector2d& moved_px, const Eigen::Vector2d& speed_change_pxps);

  /// Follows on from here as a light that has just been found. Of what was seen of it before,
  /// `paired` sightings were as one of a pair.
  void start_anew(CameraTime time, int paired);

  /// Sets the records from before that time aside; of what was set aside the longest stretch is
  /// kept.
  void set_aside_before(CameraTime time);
  /// As it was when it left the records that are set aside.
  Lamp before_doubt() const;
  /// The first of all records that are held, set aside or not; null where none is.
  const LampRecord* oldest() const {
    return !set_aside.empty() ? &set_aside.front() : !records.empty() ? &records.front() : nullptr;
  }

  const Eigen::Vector2d& at_px() const { return at_px_; }
  const Eigen::Vector2d& velocity_pxps() const { return velocity_pxps_; }
  double position_sigma_px() const;
  double velocity_sigma_pxps() const;
  /// Rate of change of depth over depth, from the image motion (1/s), negative when nearing.
  double depth_rate_per_s() const { return depth_rate_per_s_; }
  const LampPlace& place() const { return place_; }

  /// headlamp or taillamp once the sightings agree; other before that.
  LampKind kind() const;
  double log_flux() const { return log_flux_; }
  /// Extent of all places since it was found, held or not, with the movement of the whole image
  /// taken out.
  double wandered_px() const { return (most_px_ - least_px_).norm(); }
  bool seen_at(std::int64_t frame) const { return last_frame_ == frame; }
  /// The looks before `first` were of a vehicle's lamp: it is a light of its own from there on.
  void leave_to_pair(std::vector<LampRecord>::const_iterator first);
  double unseen_s(CameraTime now) const;
  double lived_s() const;
  CameraTime first_time() const { return first_time_; }
  int sightings() const { return sightings_; }

  std::uint64_t id = 0;  ///< no other light of the tracker has it
  std::vector<LampRecord> records;
  std::vector<LampRecord> set_aside;  ///< from before a doubtful step
  RunningShare red;                   ///< has the colour of a tail lamp, however dim
  RunningShare lamp_like;             ///< shines like a lamp, not like something lit
  RunningShare above;                 ///< stands above where a lamp on the road can
  RunningShare mirrored;              ///< looks like the road reflection of another lamp
  RunningShare reflected;             ///< that, or was unseen where a streak was
  RunningShare below;  ///< in the column below another lamp, moves along with it, and is not its
                       ///< mirror image
  RunningShare on_vehicle;  ///< moves as a part of a vehicle that has its two lamps already
  std::optional<CameraTime> doubtful_at;  ///< when it last may have passed to another light
  int paired_sightings = 0;               ///< as one of a pair that came apart
  bool fixed = false;                     ///< judged to be standing in the world
  Vehicle* vehicle = nullptr;             ///< that has it as a lamp

 private:
  void correct(const Eigen::Vector2d& measured_px, double sigma_px);
  void remember(const Spot& spot, const Eigen::Vector2d& off_px, std::int64_t frame,
                CameraTime time);

  Eigen::Vector2d at_px_, velocity_pxps_;
  Eigen::Matrix4d covariance_;  ///< of (place, velocity)
  double state_s_;              ///< clip time of place and velocity
  double strain_ = 1.0;         ///< squares of late innovations over what they should be
  LampPlace place_;
  double depth_rate_per_s_ = 0.0;
  Eigen::Vector2d drift_px_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d least_px_, most_px_;
  double log_flux_ = 0.0;
  int head_votes_ = 0, tail_votes_ = 0, sightings_ = 0;
  int unsure_votes_ = 0;  ///< by colours that tell nothing against its kind
  std::int64_t last_frame_ = 0;
  CameraTime first_time_, last_time_;
};

}  // namespace vildar
