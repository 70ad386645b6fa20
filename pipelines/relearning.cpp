#include "pipelines/relearning.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/quantity.h"
#include "optics/camera.h"
#include "pipelines/calibration_inputs.h"

namespace vildar {
namespace {

// Where the quantity of a key stands; empty for the focal length, which is two numbers and a sigma,
// and for what the site does not have.
std::vector<Uncertain*> places_of(const std::string& key, Site& site) {
  CameraSite& camera = *site.camera;
  LampsSite& lamps = site.lamps;
  const auto where_given = [](auto& length_m) { return length_m ? &*length_m : nullptr; };
  std::vector<std::pair<std::string, Uncertain*>> places{
      {"camera.yaw_deg", &camera.yaw_rad},
      {"camera.pitch_deg", &camera.pitch_rad},
      {"camera.roll_deg", &camera.roll_rad},
      {"lamps.height_m", where_given(lamps.height_m)},
      {"lamps.separation_m", where_given(lamps.separation_m)},
      {"lamps.tail_height_m", where_given(lamps.tail_height_m)},
      {"lamps.tail_separation_m", where_given(lamps.tail_separation_m)}};
  for (LaneSite& lane : site.road.lanes)
    places.emplace_back("road.lanes." + lane.id + ".lateral_m", &lane.lateral_m);
  for (std::size_t k = 0; k < site.photodiodes.size(); ++k) {
    PhotodiodeSite& diode = site.photodiodes[k];
    places.emplace_back("time_offset_s", &diode.time_offset_s);
    places.emplace_back("photodiodes[" + std::to_string(k) + "].gain_ratio", &diode.gain_ratio);
  }
  std::vector<Uncertain*> found;
  for (const auto& [name, place] : places)
    if (name == key && place) found.push_back(place);
  return found;
}

bool in_degrees(const std::string& key) { return key.ends_with("_deg"); }

void put(const std::string& key, const Uncertain& value, Site& site) {
  if (key == "camera.focal_px") {
    CameraSite& camera = *site.camera;
    const double factor = value.mean / Camera(camera).focal_px();
    for (double& focal_px : camera.focal_px) focal_px *= factor;
    camera.focal_std_px = value.std;
    return;
  }
  const auto in_site = [&](double one) {
    return in_degrees(key) ? radians_from_degrees(one) : one;
  };
  for (Uncertain* place : places_of(key, site)) *place = {in_site(value.mean), in_site(value.std)};
}

// But for the digits that units cost.
bool same(const Uncertain& one, const Uncertain& other) {
  constexpr double kRounding = 1e-9;
  const double scale = std::max(std::abs(other.mean), other.std);
  return std::abs(one.mean - other.mean) <= kRounding * scale &&
         std::abs(one.std - other.std) <= kRounding * scale;
}

}  // namespace

std::optional<Uncertain> said_of(const std::string& key, const Site& site) {
  if (key == "camera.focal_px")
    return Uncertain{Camera(*site.camera).focal_px(), site.camera->focal_std_px};
  Site copy = site;
  const std::vector<Uncertain*> places = places_of(key, copy);
  if (places.empty()) return std::nullopt;
  const auto in_file = [&](double one) {
    return in_degrees(key) ? degrees_from_radians(one) : one;
  };
  return Uncertain{in_file(places.front()->mean), in_file(places.front()->std)};
}

Site before_learning(Site site, const std::optional<LearnedFrom>& learned,
                     std::vector<std::string>& warnings) {
  if (!learned || !site.camera) return site;
  for (const LearnedFrom::Quantity& quantity : learned->quantities) {
    const auto now = said_of(quantity.key, site);
    if (now && same(*now, quantity.learned)) put(quantity.key, quantity.stated, site);
    if (!now)
      warnings.push_back(site.file.string() + ": learned: the file has no " + quantity.key +
                         "; where that was renamed, what stands there was learned, and is counted "
                         "as known before: rename it here, too");
  }
  return site;
}

std::vector<std::string> clips_of(std::span<const std::filesystem::path> runs) {
  std::vector<std::string> clips;
  for (const std::filesystem::path& run : runs)
    for (const GivenFile& given : inputs_of_run(run))
      if (given.role == "clip" && !given.sha256.empty()) clips.push_back(given.sha256);
  return clips;
}

void warn_of_forgotten(const std::optional<LearnedFrom>& learned,
                       std::span<const std::string> clips, std::vector<std::string>& warnings) {
  if (!learned) return;
  const auto forgotten = std::ranges::count_if(learned->clips, [&](const std::string& clip) {
    return std::ranges::find(clips, clip) == clips.end();
  });
  if (forgotten == 0) return;
  warnings.push_back(std::to_string(forgotten) + " of the " +
                     std::to_string(learned->clips.size()) +
                     " clips that the site file was learned from are not among these runs: what "
                     "they told is no part of this; give the runs of all clips of this mounting "
                     "together");
}

}  // namespace vildar
