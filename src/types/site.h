#pragma once

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "types/psf.h"
#include "types/vehicle_track.h"

namespace vildar {

/// A quantity of the site file: known (`std == 0`) or a normal prior.
struct Uncertain {
  double mean = 0.0;
  double std = 0.0;

  bool operator==(const Uncertain&) const = default;
};

enum class DistortionModel { none, brown, fisheye };
enum class ResponseKind { linear, gamma, srgb, bt709, table };

/// A point-spread function as it was calibrated.
struct PsfSite {
  PsfShape shape;
  double wing_share_std = 0.0;

  bool operator==(const PsfSite&) const = default;
};

struct CameraSite {
  int width_px = 0;
  int height_px = 0;
  std::array<double, 2> focal_px{0.0, 0.0};
  double focal_std_px = 0.0;  ///< of both together, in proportion
  std::array<double, 2> principal_px{0.0, 0.0};
  DistortionModel distortion = DistortionModel::none;
  std::array<double, 5>
      distortion_coefficients{};  ///< brown: k1 k2 p1 p2 k3; fisheye: the first four
  std::array<Uncertain, 3> position_m{};
  Uncertain yaw_rad, pitch_rad, roll_rad;
  std::optional<double> exposure_s;
  double rolling_shutter_s = 0.0;
  ResponseKind response = ResponseKind::srgb;
  double response_exponent = 2.2;      ///< for gamma
  std::vector<double> response_table;  ///< 256 values, linear light of each code, for table
  std::optional<PsfSite> psf;          ///< unknown when absent
  std::optional<Uncertain> gain_db;    ///< of the camera's intensity: unknown when absent
  Uncertain path_loss_exponent{2.0, 0.0};

  bool operator==(const CameraSite&) const = default;
};

struct PhotodiodeSite {
  std::string id;
  std::array<Uncertain, 3> position_m{};
  double yaw_rad = 0.0;
  double pitch_rad = 0.0;
  double half_field_of_view_rad = 1.2217304763960306;
  std::optional<double> area_m2;
  Uncertain gain_ratio{1.0, 0.0};  ///< to the first photodiode
  bool gain_ratio_told = true;     ///< false: one of the same type, as a guess
  std::optional<double> responsivity_a_per_w;
  std::optional<double> transimpedance_v_per_a;
  std::optional<double> volts_per_count;
  std::optional<double> full_scale_v;
  Uncertain time_offset_s;  ///< t_clip = t_pd + time_offset_s

  bool operator==(const PhotodiodeSite&) const = default;
};

enum class RoadKind { straight, curved };
enum class Turn { left, right };

struct LaneSite {
  std::string id;
  Uncertain lateral_m;
  double width_m = 3.5;
  Direction direction = Direction::oncoming;

  bool operator==(const LaneSite&) const = default;
};

struct RoadSite {
  RoadKind kind = RoadKind::straight;
  Uncertain straight_m;               ///< from x = 0 to where a bend begins; see bend_begins_m()
  std::optional<Uncertain> radius_m;  ///< of the line y = 0
  Turn turn = Turn::left;
  std::vector<LaneSite> lanes;
  std::optional<double> speed_limit_mps;

  bool operator==(const RoadSite&) const = default;
};

/// One kind of vehicle by its lamps, and how many of all vehicles are of this kind.
struct LampClass {
  std::string id;
  double share = 1.0;  ///< relative to the other classes
  Uncertain height_m;
  std::optional<Uncertain> separation_m;  ///< of headlamps, as height_m; absent: one lamp alone
  std::optional<Uncertain> tail_height_m{}, tail_separation_m{};

  bool operator==(const LampClass&) const = default;
};

struct LampsSite {
  std::optional<Uncertain> height_m;      ///< of headlamps; with classes, of all of them together
  std::optional<Uncertain> separation_m;  ///< the same
  std::vector<LampClass> classes;
  std::optional<Uncertain> tail_height_m;      ///< of the classes that have none of their own, too
  std::optional<Uncertain> tail_separation_m;  ///< the same, of those with two headlamps

  /// Whether the classes part vehicles that drive away, too.
  bool classes_tell_tails() const {
    for (const LampClass& one : classes)
      if (one.tail_height_m || one.tail_separation_m) return true;
    return false;
  }

  bool operator==(const LampsSite&) const = default;
};

struct ChannelSite {
  std::optional<Uncertain> gain_db;
  std::optional<Uncertain> path_loss_exponent;
  std::optional<double> half_power_angle_rad;
  std::string beam;  ///< low_beam, high_beam or an LM-63 file; empty where the power law holds
  double luminous_efficacy_lm_per_w = 300.0;
  Uncertain lamp_power_w{1.0, 0.0};
  bool lamp_power_told = true;  ///< false: the paper's transmitter, as a guess

  bool beam_is_file() const { return !beam.empty() && beam != "low_beam" && beam != "high_beam"; }
  bool operator==(const ChannelSite&) const = default;
};

struct EgoSample {
  double time_s = 0.0;
  double speed_mps = 0.0;
  double yaw_rate_rad_per_s = 0.0;

  bool operator==(const EgoSample&) const = default;
};

/// Dashcam only. Either a constant speed or a trace.
struct EgoSite {
  Uncertain speed_mps;               ///< with a trace the std alone counts: of its speeds together
  std::filesystem::path trace_path;  ///< empty: constant speed
  std::vector<EgoSample> trace;      ///< filled by the loader, time increasing

  /// Whether all that is told is that it does not drive.
  bool stands() const { return trace_path.empty() && trace.empty() && speed_mps.mean == 0.0; }

  /// Whether yaw rates tell how the vehicle turns; where they do not, it follows the road.
  bool turns_known() const {
    return std::any_of(trace.begin(), trace.end(),
                       [](const EgoSample& sample) { return sample.yaw_rate_rad_per_s != 0.0; });
  }

  bool operator==(const EgoSite&) const = default;
};

/// What a calibration from runs put in the place of what a site file said before, so that it can be
/// learned anew from there: runs that are given again would else count twice.
struct LearnedFrom {
  struct Quantity {
    std::string key;  ///< of the site file, in whose unit the next two are
    Uncertain stated, learned;

    bool operator==(const Quantity&) const = default;
  };
  std::vector<Quantity> quantities;
  std::vector<std::string> clips;  ///< SHA-256, hexadecimal

  bool operator==(const LearnedFrom&) const = default;
};

/// The parts of a site file that runs have taught.
struct LearnedSite {
  std::optional<LearnedFrom> mount, photodiode;  ///< by `vildar calibrate` of that name

  bool operator==(const LearnedSite&) const = default;
};

/// The site file of the contract (SPEC 2), angles in radians, paths resolved.
struct Site {
  std::filesystem::path file;
  std::optional<CameraSite> camera;
  std::vector<PhotodiodeSite> photodiodes;
  double mains_hz = 50.0;
  RoadSite road;
  LampsSite lamps;
  std::optional<ChannelSite> channel;
  std::optional<EgoSite> ego;
  LearnedSite learned;

  bool operator==(const Site&) const = default;
};

}  // namespace vildar
