#include "synth/scenario_reading.h"

#include "optics/atmosphere.h"

namespace vildar {
namespace {

constexpr std::array<Choice<ClipCodec>, 4> kCodecWords{{{"h264", ClipCodec::h264},
                                                        {"h265", ClipCodec::h265},
                                                        {"mjpeg", ClipCodec::mjpeg},
                                                        {"ffv1", ClipCodec::ffv1}}};
constexpr std::array<Choice<PowerQuantity>, 4> kQuantityWords{
    {{"power_w", PowerQuantity::power_w},
     {"current_a", PowerQuantity::current_a},
     {"voltage_v", PowerQuantity::voltage_v},
     {"counts", PowerQuantity::counts}}};

constexpr NumberRule kSampleRate_hz{100.0, 100'000.0, false, false};
constexpr NumberRule kShare{0.0, 1.0, false, true};

}  // namespace

Waveform read_mains_flicker(const YamlMap& map, double mains_hz) {
  double depth = 0.0, phase = 0.0;
  map.read("flicker", depth, NumberRule{0.0, 1.0});
  map.read("flicker_phase", phase, NumberRule{0.0, 1.0});
  return depth > 0.0 ? Waveform::sine(2.0 * mains_hz, depth, phase) : Waveform();
}

SignScene read_sign(const YamlMap& map) {
  SignScene sign;
  map.require("position_m", sign.position_m);
  map.require("width_m", sign.width_m, kPositive);
  map.require("height_m", sign.height_m, kPositive);
  map.read_degrees("facing_deg", sign.facing_rad);
  map.read("luminance_cd_per_m2", sign.luminance_cd_per_m2, kNotNegative);
  map.read("red_blue", sign.red_blue, kNotNegative);
  return sign;
}

void read_image(const YamlMap& map, ImageScene& image) {
  map.read("full_well_e", image.full_well_e, kPositive);
  map.read("electrons_per_lux_s", image.electrons_per_lux_s, kPositive);
  map.read("read_noise_e", image.read_noise_e, kNotNegative);
  map.read("shot_noise", image.shot_noise);
  map.read("black_level_e", image.black_level_e, kNotNegative);
  map.read("core_sigma_px", image.core_sigma_px, NumberRule{0.5, 20.0});
  map.read("wing_share", image.wing_share, kShare);
  map.read("wing_scale_px", image.wing_scale_px, NumberRule{0.5, 20.0});
  map.read("wing_exponent", image.wing_exponent, NumberRule{2.05, 8.0});
  map.read("sky_cd_per_m2", image.sky_cd_per_m2, kNotNegative);
  map.read("road_cd_per_m2", image.road_cd_per_m2, kNotNegative);
  map.read("glow_cd_per_m2", image.glow_cd_per_m2, kNotNegative);
  map.read_degrees("glow_height_deg", image.glow_height_rad, NumberRule{0.0, 90.0, true, false});
  map.read("dark_e_per_s", image.dark_e_per_s, kNotNegative);
  map.read("prnu", image.prnu, NumberRule{0.0, 0.2});
  map.read("bayer", image.bayer);
  map.read("road_light", image.road_light);
  map.read("own_lamps", image.own_lamps);
}

void read_frame_times(const YamlMap& map, FrameTimesScene& times) {
  map.read("jitter_s", times.jitter_s, kNotNegative);
  map.read("dropped_share", times.dropped_share, kShare);
  map.read("dropped", times.dropped, NumberRule{1.0, 1e9});
}

void read_encoder(const YamlMap& map, EncoderScene& encoder) {
  map.read("codec", encoder.codec, kCodecWords);
  if (encoder.codec == ClipCodec::mjpeg)
    map.read("quality", encoder.quality, NumberRule{2.0, 31.0});
  if (encoder.codec == ClipCodec::ffv1 || encoder.codec == ClipCodec::mjpeg) {
    const bool lossless = encoder.codec == ClipCodec::ffv1;
    const char* fault = lossless ? "ffv1 is lossless" : "mjpeg knows no such setting";
    const char* remedy = lossless ? "remove it, or use codec h264" : "use quality, 2 to 31";
    map.refuse("crf", fault, remedy);
    map.refuse("bitrate_bps", fault, remedy);
    return;
  }
  if (map.has("bitrate_bps"))
    map.refuse("crf", "is given beside bitrate_bps", "keep one of the two");
  else
    map.read("crf", encoder.crf, NumberRule{0.0, 51.0});
  map.read("bitrate_bps", encoder.bitrate_bps, NumberRule{10'000.0, 1e9});
}

void read_photodiode_scene(const YamlMap& map, PhotodiodeScene& scene) {
  map.read("rate_hz", scene.rate_hz, kSampleRate_hz);
  map.read("snr_db", scene.snr_db, NumberRule{-60.0, 200.0});
  if (scene.snr_db)
    map.refuse("noise_w", "is given beside snr_db", "keep one of the two");
  else
    map.read("noise_w", scene.noise_w, kNotNegative);
  map.read("ambient_w", scene.ambient_w, kNotNegative);
  map.read("ambient_flicker", scene.ambient_flicker, NumberRule{0.0, 1.0});
  map.read("bandwidth_hz", scene.bandwidth_hz, kPositive);
  map.read("shot_noise", scene.shot_noise);
  map.read("temperature_k", scene.temperature_k, kPositive);
  map.read("quantity", scene.quantity, kQuantityWords);
  map.read("adc_bits", scene.adc_bits, NumberRule{1.0, 32.0});
  const bool counts = scene.quantity == PowerQuantity::counts;
  if (counts && !scene.adc_bits)
    map.problem("adc_bits", "is missing, but the quantity is counts",
                "say how many bits they have");
  if (counts) {
    map.refuse("full_scale_w", "is given beside the quantity counts",
               "remove it; volts_per_count of the site says it");
  } else if (scene.adc_bits) {
    map.require("full_scale_w", scene.full_scale_w, kPositive);
  } else {
    map.refuse("full_scale_w", "is given without adc_bits", "give both or neither");
  }
  map.read("clock_drift_ppm", scene.clock_drift_ppm, NumberRule{-10'000.0, 10'000.0});
  for (const YamlMap& item : map.maps("gaps")) {
    TraceGap gap;
    item.require("from_s", gap.from_s);
    item.require("to_s", gap.to_s);
    if (gap.to_s <= gap.from_s) item.problem("to_s", "does not come after from_s", "swap the two");
    scene.gaps.push_back(gap);
  }
  map.read("digits", scene.digits, NumberRule{3.0, 17.0});
}

void read_weather(const YamlMap& map, double& extinction_per_m) {
  std::optional<double> visibility_m, rain_mm_per_h, extinction;
  map.read("extinction_per_m", extinction, kNotNegative);
  map.read("visibility_m", visibility_m, kPositive);
  map.read("rain_mm_per_h", rain_mm_per_h, kNotNegative);
  if (extinction.has_value() + visibility_m.has_value() + rain_mm_per_h.has_value() > 1)
    map.problem("", "says the extinction of the air more than once",
                "keep one of extinction_per_m, visibility_m and rain_mm_per_h");
  if (extinction) extinction_per_m = *extinction;
  if (visibility_m) extinction_per_m = extinction_from_visibility_per_m(Metres(*visibility_m));
  if (rain_mm_per_h) extinction_per_m = extinction_of_rain_per_m(*rain_mm_per_h);
}

}  // namespace vildar
