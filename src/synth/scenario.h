#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "types/site.h"

namespace vildar {

enum class VehicleKind { car, lorry, motorcycle };
enum class VehicleLamps { head, tail };

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
};

struct StreetLampScene {
  std::array<double, 3> position_m{};
  double intensity_cd = 0.0;
  double radius_m = 0.15;
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
};

enum class ClipCodec { h264, ffv1 };
struct EncoderScene {
  ClipCodec codec = ClipCodec::h264;
  int crf = 20;
  std::optional<int> bitrate_bps;  ///< instead of the constant quality
};

struct PhotodiodeScene {
  double rate_hz = 1000.0;
  std::optional<double> snr_db;  ///< 20 log10(P(t = 0) / sigma); without it `noise_w`
  double noise_w = 0.0;          ///< standard deviation of one sample
  double ambient_w = 0.0;
  int digits = 6;  ///< significant digits written
};

/// Everything that a rendered clip shows. The site's means are the truth.
struct Scenario {
  std::filesystem::path file;
  double duration_s = 0.0;
  double frame_rate_hz = 25.0;
  std::uint64_t seed = 1;
  Site site;
  std::vector<VehicleScene> vehicles;
  std::vector<StreetLampScene> street_lamps;
  ImageScene image;
  EncoderScene encoder;
  PhotodiodeScene photodiode;
  bool wet_road = false;
};

/// Reads a scenario file; throws ConfigError with every problem found in it.
Scenario load_scenario(const std::filesystem::path& file);

}  // namespace vildar
