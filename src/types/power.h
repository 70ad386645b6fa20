#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace vildar {

/// What the samples of a photodiode file are, before the site file turns them into watts.
enum class PowerQuantity : std::uint8_t { power_w, current_a, voltage_v, counts };

/// Raw content of a photodiode file; values as written, nothing dropped but rows that cannot be
/// read.
struct PhotodiodeRecording {
  PowerQuantity quantity = PowerQuantity::power_w;
  bool shares = false;  ///< counts are shares of full scale where nothing says what one is
  std::vector<std::string>
      ids;                     ///< one per channel; empty text for a file with one unnamed channel
  std::vector<double> time_s;  ///< photodiode clock, in file order
  std::vector<std::vector<float>>
      values;  ///< [channel][sample]; NaN where the cell is empty or not a number
  std::int64_t rows_read = 0;
  std::map<std::string, std::int64_t> rejected;  ///< reason -> rows that could not be read
  bool damaged = false;               ///< something in the file was unreadable or inconsistent
  std::vector<std::string> warnings;  ///< each names file, line, fault and remedy
};

/// Stamps of two samples in a row of which the second is earlier.
struct StampFall {
  double before_s = 0.0, after_s = 0.0;

  bool operator==(const StampFall&) const = default;
};

/// A stretch in which samples were left out as clipped; photodiode clock.
struct ClippedTime {
  double from_s = 0.0, to_s = 0.0;

  bool operator==(const ClippedTime&) const = default;
};

/// Light of lamps that pulse, evened out; photodiode clock.
struct PulsingLight {
  double from_s = 0.0, to_s = 0.0;
  double frequency_hz = 0.0;  ///< or an alias, where it is more than half the sampling's
  double duty = 0.0;          ///< share of the time in which they are on
  double duty_std = 0.0;      ///< where edges always fall between the same two samples

  bool operator==(const PulsingLight&) const = default;
};

/// What is known of a photodiode's trace as a whole, and of any part of it.
struct PowerTraceFacts {
  std::string photodiode_id;
  int photodiode = 0;             ///< index into Site::photodiodes
  double sample_period_s = 0.0;   ///< median spacing
  double noise_sigma_w = 0.0;     ///< of one sample, from successive differences; white part only
  double rounding_sigma_w = 0.0;  ///< of the converter's steps in a mean of many samples, where
                                  ///< noise is too little to even them out
  double ambient_w = 0.0;         ///< level with no vehicle near
  double ambient_sigma_w = 0.0;   ///< of that level; wide where some vehicle is near throughout
  double mains_hz = 0.0;          ///< as its flicker shows; 0: it shows none
  double flicker_w = 0.0;         ///< amplitude of the mains flicker taken out
  double drift_w = 0.0;           ///< range of the slow changes of ambient light taken out
  double switched_w = 0.0;        ///< largest jump of lights switched on and off, taken out
  std::vector<PulsingLight> pulsing;             ///< in order of time; may overlap
  std::map<std::string, std::int64_t> rejected;  ///< reason -> samples left out
  std::vector<ClippedTime> clipped;              ///< in order; those less than 0.05 s apart are one
  std::optional<StampFall> fall;                 ///< the first, where stamps go back
  bool blocks_constant_light = false;  ///< the amplifier: the level swings back after each vehicle

  bool operator==(const PowerTraceFacts&) const = default;
};

/// Power of one photodiode on strictly increasing times; gaps are simply absent samples.
struct PowerTrace : PowerTraceFacts {
  std::vector<double> time_s;  ///< photodiode clock
  std::vector<float>
      power_w;  ///< ambient's mean level not yet removed; negative within noise is noise
};

/// Mean power over one block of a trace.
struct PowerBlock {
  double time_s = 0.0;  ///< middle of the block, clip time (or photodiode time without a clip)
  double duration_s = 0.0;
  double power_w = 0.0;  ///< ambient not removed
  double sigma_w = 0.0;
  int samples = 0;
};

/// A stretch of a trace in which one vehicle passes; photodiode clock.
struct PowerPass {
  double from_s = 0.0;
  double to_s = 0.0;
  double peak_s = 0.0;
  double others_w =
      0.0;  ///< light that is left, above ambient, once this vehicle is past: of others
  bool cut_off = false;  ///< the record ends before it is past: others_w is not known
  int photodiode = 0;    ///< whose light it was found in: index in the site
  /// After how long the same light comes again and again, of lamps that flash; 0: not.
  double comes_again_s = 0.0;
};

}  // namespace vildar
