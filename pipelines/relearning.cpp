#include "pipelines/relearning.h"

#include <algorithm>

#include "core/quantity.h"
#include "optics/camera.h"
#include "pipelines/calibration_inputs.h"

namespace vildar {
namespace {

constexpr std::string_view kDegrees = "_deg";

// Where the quantity of a key stands; null for the focal length, for what is not in the site, and
// for what it does not call unsure.
std::vector<Uncertain*> places_of(const std::string& key, Site& site) {
  CameraSite& camera = *site.camera;
  LampsSite& lamps = site.lamps;
  const auto given = [](auto& optional) { return optional ? &*optional : nullptr; };
  std::vector<std::pair<std::string, Uncertain*>> places{
      {"camera.yaw_deg", &camera.yaw_rad},
      {"camera.pitch_deg", &camera.pitch_rad},
      {"camera.roll_deg", &camera.roll_rad},
      {"lamps.height_m", given(lamps.height_m)},
      {"lamps.separation_m", given(lamps.separation_m)},
      {"lamps.tail_height_m", given(lamps.tail_height_m)},
      {"lamps.tail_separation_m", given(lamps.tail_separation_m)}};
  for (LaneSite& lane : site.road.lanes)
    places.emplace_back("road.lanes." + lane.id + ".lateral_m", &lane.lateral_m);
  for (std::size_t k = 0; k < site.photodiodes.size(); ++k) {
    PhotodiodeSite& diode = site.photodiodes[k];
    places.emplace_back("time_offset_s", &diode.time_offset_s);
    places.emplace_back("photodiodes[" + std::to_string(k) + "].gain_ratio", &diode.gain_ratio);
  }
  std::vector<Uncertain*> found;
  for (const auto& [name, place] : places)
    if (name == key && place && place->std > 0.0) found.push_back(place);
  return found;
}

void put_back(const LearnedFrom::Before& before, Site& site) {
  CameraSite& camera = *site.camera;
  if (before.key == "camera.focal_px" && camera.focal_std_px > 0.0) {
    const double factor = before.stated.mean / Camera(camera).focal_px();
    for (double& focal_px : camera.focal_px) focal_px *= factor;
    camera.focal_std_px = before.stated.std;
    return;
  }
  const bool angle = before.key.ends_with(kDegrees);
  const auto in_site = [&](double value) { return angle ? radians_from_degrees(value) : value; };
  for (Uncertain* place : places_of(before.key, site))
    *place = {in_site(before.stated.mean), in_site(before.stated.std)};
}

}  // namespace

Site before_learning(Site site, const std::optional<LearnedFrom>& learned) {
  if (learned && site.camera)
    for (const LearnedFrom::Before& before : learned->before) put_back(before, site);
  return site;
}

std::vector<std::string> clips_of(std::span<const std::filesystem::path> runs) {
  std::vector<std::string> clips;
  for (const std::filesystem::path& run : runs)
    for (const GivenFile& given : inputs_of_run(run))
      if (given.role == "clip" && !given.sha256.empty()) clips.push_back(given.sha256);
  return clips;
}

std::string text_of_forgotten(const std::optional<LearnedFrom>& learned,
                              std::span<const std::string> clips) {
  if (!learned) return "";
  const auto forgotten = std::ranges::count_if(learned->clips, [&](const std::string& clip) {
    return std::ranges::find(clips, clip) == clips.end();
  });
  if (forgotten == 0) return "";
  return std::to_string(forgotten) + " of the " + std::to_string(learned->clips.size()) +
         " clips that the site file was learned from are not among these runs: what they told is "
         "no part of this; give the runs of all clips of this mounting together";
}

}  // namespace vildar
