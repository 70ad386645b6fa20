#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/quantity.h"
#include "optics/lamp_beam.h"
#include "synth/waveform.h"
#include "types/power.h"
#include "types/site.h"

namespace vildar {

enum class VehicleKind { car, lorry, motorcycle };
enum class VehicleLamps { head, tail };

/// From `from_s` on, until the next change.
struct SpeedChange {
  double from_s = 0.0;  ///< > 0, increasing along the list
  double acceleration_mps2 = 0.0;
};

/// A smooth move sideways; speed, slope and curvature begin and end at zero.
struct LaneChange {
  double from_s = 0.0;
  double duration_s = 3.0;
  int to_lane = 0;       ///< index into Site::road.lanes
  double shift_m = 0.0;  ///< to the left of the way up-road
};

/// The nose of a vehicle that goes up and down.
struct PitchScene {
  double amplitude_rad = 0.0;
  double frequency_hz = 1.5;
  double phase_rad = 0.0;
};

/// A vehicle of a scenario: what it is, and how it moves along its lane.
struct VehicleScene {
  std::string id;
  VehicleKind kind = VehicleKind::car;
  int lane = 0;            ///< index into Site::road.lanes
  double speed_mps = 0.0;  ///< over the ground at t = 0, >= 0; a vehicle that has stopped stays
  double acceleration_mps2 = 0.0;  ///< along its way, positive when it speeds up
  double along_at_zero_m = 0.0;    ///< length of the lane's path from x = 0 to its place at t = 0
  double lateral_offset_m = 0.0;   ///< to the left of the lane's middle line
  double lamp_height_m = 0.65;
  double lamp_separation_m = 1.25;  ///< 0: one lamp
  double lamp_radius_m = 0.06;
  double intensity_cd = 600.0;  ///< of each lamp toward the sensors
  VehicleLamps lamps = VehicleLamps::head;
  double power_ratio = 1.0;  ///< of its optical power over the site's lamp_power_w
  std::vector<SpeedChange> speed_changes;
  std::vector<LaneChange> lane_changes;
  PitchScene pitch;
  /// Intensity by direction of each lamp; absent: `intensity_cd` wherever the lamps face.
  std::optional<LampBeam> beam;
  Waveform waveform;  ///< of its lamps
};

struct StreetLampScene {
  std::array<double, 3> position_m{};
  double intensity_cd = 0.0;
  double radius_m = 0.15;
  Waveform waveform;
};

/// An upright lit rectangle, seen from the front alone.
struct SignScene {
  std::array<double, 3> position_m{};  ///< its middle
  double width_m = 1.0;
  double height_m = 1.0;
  double facing_rad = kPi;  ///< the way its face looks, anticlockwise from +x
  double luminance_cd_per_m2 = 100.0;
  std::array<double, 2> red_blue{1.0, 1.0};  ///< relative to white of the same luminance
};

/// Unsteadiness of the camera: a seeded sum of sines about `frequency_hz`.
struct ShakeScene {
  double yaw_std_rad = 0.0;
  double pitch_std_rad = 0.0;
  double frequency_hz = 3.0;
};

/// How the camera turns light into codes, beyond what the site file says of it.
struct ImageScene {
  double full_well_e = 10000.0;  ///< electrons that give nominal white; more are lost
  /// Electrons that 1 lx at the lens gives in one second, over the whole picture of the lamp.
  /// 6.3e10 is an f/2 lens of 8 mm before a sensor of 54 % quantum efficiency.
  double electrons_per_lux_s = 6.3e10;
  double read_noise_e = 4.0;
  bool shot_noise = true;
  double black_level_e = 20.0;  ///< left over by the black-level correction
  double core_sigma_px = 0.9;
  double wing_share = 0.03;  ///< of the light of a lamp, scattered far out by lens and cover
  double wing_scale_px = 2.0;
  double wing_exponent = 2.5;  ///< light falls as r^-wing_exponent far out
  double sky_cd_per_m2 = 0.002;
  double road_cd_per_m2 = 0.05;
  double glow_cd_per_m2 = 0.0;   ///< of the sky at the horizon, above sky_cd_per_m2
  double glow_height_rad = 0.1;  ///< elevation at which the glow has fallen to 1 / e
  double dark_e_per_s = 0.0;     ///< dark current; its mean is taken off, its noise stays
  double prnu = 0.0;             ///< standard deviation of the pixels' sensitivities, relative
  bool road_light = true;        ///< headlamps and street lamps light the road
  bool own_lamps = false;        ///< the sensors' own vehicle lights the road before it
  bool bayer = false;  ///< each pixel sees one colour; the others come from its neighbours
};

enum class ClipCodec { h264, h265, mjpeg, ffv1 };
struct EncoderScene {
  ClipCodec codec = ClipCodec::h264;
  int crf = 20;
  std::optional<int> bitrate_bps;  ///< instead of the constant quality
  int quality = 3;                 ///< mjpeg: 2 (best) to 31
};

/// When pictures are taken.
struct FrameTimesScene {
  double jitter_s = 0.0;       ///< standard deviation of each picture's delay
  double dropped_share = 0.0;  ///< of pictures, at random, that never arrive
  std::vector<int> dropped;    ///< places in the undisturbed order that never arrive
};

/// A time without samples, photodiode clock.
struct TraceGap {
  double from_s = 0.0;
  double to_s = 0.0;
};

/// How the photodiodes turn light into numbers, beyond what the site file says of them.
struct PhotodiodeScene {
  double rate_hz = 1000.0;
  std::optional<double> snr_db;         ///< 20 log10(P(t = 0) / sigma); without it `noise_w`
  double noise_w = 0.0;                 ///< standard deviation of one sample, white
  double ambient_w = 0.0;               ///< mean, beside that of the scenario's street lamps
  double ambient_flicker = 0.0;         ///< relative amplitude at twice the mains frequency
  std::optional<double> bandwidth_hz;   ///< one pole; absent: every sample is the light at its time
  bool shot_noise = false;              ///< needs responsivity_a_per_w
  std::optional<double> temperature_k;  ///< thermal noise of the feedback resistor
  std::optional<int> adc_bits;
  std::optional<double> full_scale_w;  ///< of the converter, for the first photodiode's gain
  PowerQuantity quantity = PowerQuantity::power_w;  ///< what the file holds
  double clock_drift_ppm = 0.0;                     ///< t_clip = t_pd (1 + drift) + time_offset_s
  std::vector<TraceGap> gaps;
  int digits = 6;  ///< significant digits written
};

/// Everything that a rendered clip shows. The site's means are the truth.
struct Scenario {
  std::filesystem::path file;
  std::vector<std::filesystem::path> site_files;  ///< that it names
  double duration_s = 0.0;
  double frame_rate_hz = 25.0;
  std::uint64_t seed = 1;
  Site site;
  /// What site.yaml says, where that is not the truth; its sensors are those of `site`.
  std::optional<Site> told_site;
  std::vector<VehicleScene> vehicles;
  std::vector<StreetLampScene> street_lamps;
  std::vector<SignScene> signs;
  ShakeScene shake;
  ImageScene image;
  FrameTimesScene frame_times;
  EncoderScene encoder;
  PhotodiodeScene photodiode;
  bool wet_road = false;
  double extinction_per_m = 0.0;  ///< of the air
};

/// Reads a scenario file; throws ConfigError with every problem found in it.
Scenario load_scenario(const std::filesystem::path& file);

}  // namespace vildar
