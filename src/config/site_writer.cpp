#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "config/site_file.h"
#include "config/site_words.h"
#include "core/quantity.h"
#include "core/text.h"

namespace vildar {
namespace {

namespace fs = std::filesystem;

template <class E, std::size_t N>
std::string word_of(E value, const std::array<Choice<E>, N>& words) {
  for (const Choice<E>& word : words)
    if (word.value == value) return std::string(word.name);
  return {};
}

/// Double-quoted, so that no text can be taken for anything else.
std::string text_of(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20) {
      std::array<char, 8> code;
      std::snprintf(code.data(), code.size(), "\\x%02x", static_cast<unsigned>(c));
      out += code.data();
    } else {
      out += c;
    }
  }
  return out + '"';
}

// As YAML 1.1 reads a number, too: to it 1e-04 is a word.
std::string number(double value) {
  std::string text = number_text(value);
  const auto exponent = text.find('e');
  if (exponent != std::string::npos && text.find('.') == std::string::npos)
    text.insert(exponent, ".0");
  return text;
}

/// The shortest degrees that turn back into the same radians, where there are any.
std::string degrees(double angle_rad) {
  const double angle_deg = degrees_from_radians(angle_rad);
  for (int digits = 1; digits <= 17; ++digits) {
    std::array<char, 40> text;
    const auto end = std::to_chars(text.data(), text.data() + text.size(), angle_deg,
                                   std::chars_format::general, digits);
    double back_deg = 0.0;
    std::from_chars(text.data(), end.ptr, back_deg);
    if (radians_from_degrees(back_deg) == angle_rad) return number(back_deg);
  }
  // Two conversions can round the same way and miss by a bit.
  for (const double towards : {-1e9, 1e9}) {
    const double near_deg = std::nextafter(angle_deg, towards);
    if (radians_from_degrees(near_deg) == angle_rad) return number(near_deg);
  }
  return number(angle_deg);
}

template <class Text>
std::string uncertain(const Uncertain& value, Text text) {
  if (value.std == 0.0) return text(value.mean);
  return "{mean: " + text(value.mean) + ", std: " + text(value.std) + "}";
}
std::string number(const Uncertain& value) {
  return uncertain(value, [](double v) { return number(v); });
}
std::string degrees(const Uncertain& value) {
  return uncertain(value, [](double v) { return degrees(v); });
}

template <class Range>
std::string list(const Range& values) {
  std::string out = "[";
  for (const auto& value : values) out += (out.size() > 1 ? ", " : "") + number(value);
  return out + "]";
}

/// Lines `key: value` at one depth; absent values leave no line.
class Lines {
 public:
  explicit Lines(std::string& out, std::string indent, std::string first)
      : out_(out), indent_(std::move(indent)), next_(std::move(first)) {}

  void put(std::string_view key, const std::string& value) {
    out_ += next_ + std::string(key) + ": " + value + "\n";
    next_ = indent_;
  }
  template <class T>
  void put(std::string_view key, const std::optional<T>& value) {
    if (value) put(key, number(*value));
  }

 private:
  std::string& out_;
  std::string indent_;
  std::string next_;
};

void write_camera(std::string& out, const CameraSite& camera) {
  out += "camera:\n";
  Lines lines(out, "  ", "  ");
  lines.put("image_size_px",
            "[" + std::to_string(camera.width_px) + ", " + std::to_string(camera.height_px) + "]");
  lines.put("focal_px", list(camera.focal_px));
  if (camera.focal_std_px > 0.0) lines.put("focal_std_px", number(camera.focal_std_px));
  lines.put("principal_px", list(camera.principal_px));
  std::string distortion = "{model: " + word_of(camera.distortion, kDistortionWords);
  if (const std::size_t count = coefficient_count(camera.distortion); count > 0)
    distortion += ", coefficients: " +
                  list(std::vector<double>(
                      camera.distortion_coefficients.begin(),
                      camera.distortion_coefficients.begin() + static_cast<std::ptrdiff_t>(count)));
  lines.put("distortion", distortion + "}");
  lines.put("position_m", list(camera.position_m));
  lines.put("yaw_deg", degrees(camera.yaw_rad));
  lines.put("pitch_deg", degrees(camera.pitch_rad));
  lines.put("roll_deg", degrees(camera.roll_rad));
  lines.put("exposure_s", camera.exposure_s);
  lines.put("rolling_shutter_s", number(camera.rolling_shutter_s));
  std::string response = "{kind: " + word_of(camera.response, kResponseWords);
  if (camera.response == ResponseKind::gamma)
    response += ", exponent: " + number(camera.response_exponent);
  if (camera.response == ResponseKind::table)
    response += ", values: " + list(camera.response_table);
  lines.put("response", response + "}");
  if (camera.psf) {
    const PsfShape& shape = camera.psf->shape;
    lines.put("psf", "{core_sigma_px: " + number(shape.core_sigma_px) + ", wing_share: " +
                         number(Uncertain{shape.wing_share, camera.psf->wing_share_std}) +
                         ", wing_scale_px: " + number(shape.wing_scale_px) +
                         ", wing_exponent: " + number(shape.wing_exponent) + "}");
  }
  lines.put("gain_db", camera.gain_db);
  lines.put("path_loss_exponent", number(camera.path_loss_exponent));
}

void write_photodiode(std::string& out, const PhotodiodeSite& diode) {
  Lines lines(out, "  ", "- ");
  lines.put("id", text_of(diode.id));
  lines.put("position_m", list(diode.position_m));
  lines.put("yaw_deg", degrees(diode.yaw_rad));
  lines.put("pitch_deg", degrees(diode.pitch_rad));
  lines.put("half_field_of_view_deg", degrees(diode.half_field_of_view_rad));
  lines.put("area_m2", diode.area_m2);
  if (diode.gain_ratio_told) lines.put("gain_ratio", number(diode.gain_ratio));
  lines.put("responsivity_a_per_w", diode.responsivity_a_per_w);
  lines.put("transimpedance_v_per_a", diode.transimpedance_v_per_a);
  lines.put("volts_per_count", diode.volts_per_count);
  lines.put("full_scale_v", diode.full_scale_v);
  lines.put("time_offset_s", number(diode.time_offset_s));
}

void write_road(std::string& out, const RoadSite& road) {
  out += "road:\n";
  Lines lines(out, "  ", "  ");
  lines.put("kind", word_of(road.kind, kRoadWords));
  lines.put("straight_m", number(road.straight_m));
  lines.put("radius_m", road.radius_m);
  lines.put("turn", word_of(road.turn, kTurnWords));
  lines.put("speed_limit_mps", road.speed_limit_mps);
  if (road.lanes.empty()) return;
  out += "  lanes:\n";
  for (const LaneSite& lane : road.lanes)
    out += "    - {id: " + text_of(lane.id) + ", lateral_m: " + number(lane.lateral_m) +
           ", width_m: " + number(lane.width_m) +
           ", direction: " + word_of(lane.direction, kDirectionWords) + "}\n";
}

void write_lamps(std::string& out, const LampsSite& lamps) {
  out += "lamps:\n";
  Lines lines(out, "  ", "  ");
  if (lamps.classes.empty()) {
    lines.put("height_m", lamps.height_m);
    lines.put("separation_m", lamps.separation_m);
  }
  lines.put("tail_height_m", lamps.tail_height_m);
  lines.put("tail_separation_m", lamps.tail_separation_m);
  if (!lamps.classes.empty()) out += "  classes:\n";
  for (const LampClass& kind : lamps.classes) {
    out += "    - {id: " + text_of(kind.id) + ", share: " + number(kind.share) +
           ", height_m: " + number(kind.height_m);
    if (kind.separation_m) out += ", separation_m: " + number(*kind.separation_m);
    if (kind.tail_height_m) out += ", tail_height_m: " + number(*kind.tail_height_m);
    if (kind.tail_separation_m) out += ", tail_separation_m: " + number(*kind.tail_separation_m);
    out += "}\n";
  }
}

void write_channel(std::string& out, const ChannelSite& channel) {
  out += "channel:\n";
  Lines lines(out, "  ", "  ");
  if (!channel.beam.empty()) {
    lines.put("beam",
              text_of(channel.beam_is_file() ? fs::absolute(channel.beam).string() : channel.beam));
  } else {
    lines.put("gain_db", channel.gain_db);
    lines.put("path_loss_exponent", channel.path_loss_exponent);
    if (channel.half_power_angle_rad)
      lines.put("half_power_angle_deg", degrees(*channel.half_power_angle_rad));
  }
  lines.put("luminous_efficacy_lm_per_w", number(channel.luminous_efficacy_lm_per_w));
  if (channel.lamp_power_told) lines.put("lamp_power_w", number(channel.lamp_power_w));
}

void write_learned(std::string& out, const std::string& command,
                   const std::optional<LearnedFrom>& from) {
  if (!from) return;
  out += "  " + command + ":\n    quantities:";
  out += from->quantities.empty() ? " []\n" : "\n";
  const auto uncertain = [](const Uncertain& value) {
    return "{mean: " + number(value.mean) + ", std: " + number(value.std) + "}";
  };
  for (const LearnedFrom::Quantity& quantity : from->quantities)
    out += "    - {key: " + text_of(quantity.key) + ", stated: " + uncertain(quantity.stated) +
           ", learned: " + uncertain(quantity.learned) + "}\n";
  out += "    clips: [";
  for (const std::string& clip : from->clips)
    out += (&clip == &from->clips.front() ? "" : ", ") + text_of(clip);
  out += "]\n";
}

}  // namespace

std::string effective_site_yaml(const Site& site) {
  std::string out = "version: 1\n";
  if (site.camera) write_camera(out, *site.camera);
  if (!site.photodiodes.empty()) out += "photodiodes:\n";
  for (const PhotodiodeSite& diode : site.photodiodes) write_photodiode(out, diode);
  out += "mains_hz: " + number(site.mains_hz) + "\n";
  write_road(out, site.road);
  if (site.lamps != LampsSite{}) write_lamps(out, site.lamps);
  if (site.channel) write_channel(out, *site.channel);
  if (site.ego) {
    out += "ego:\n";
    Lines lines(out, "  ", "  ");
    if (site.ego->trace_path.empty()) {
      lines.put("speed_mps", number(site.ego->speed_mps));
    } else {
      lines.put("trace", text_of(fs::absolute(site.ego->trace_path).string()));
      lines.put("speed_std_mps", number(site.ego->speed_mps.std));
    }
  }
  if (site.learned != LearnedSite{}) out += "learned:\n";
  write_learned(out, "mount", site.learned.mount);
  write_learned(out, "photodiode", site.learned.photodiode);
  return out;
}

}  // namespace vildar
