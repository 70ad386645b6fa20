#include "pipelines/recorded_passes.h"

#include <algorithm>
#include <map>
#include <optional>
#include <tuple>

#include "core/clock.h"
#include "core/error.h"
#include "evaluate/csv_reader.h"
#include "types/result.h"

namespace vildar {
namespace {

namespace fs = std::filesystem;

struct LampColumns {
  std::string_view u_px, v_px, u_std_px, v_std_px;
};
constexpr LampColumns kLeft{"u_left_px", "v_left_px", "u_left_std_px", "v_left_std_px"};
constexpr LampColumns kRight{"u_right_px", "v_right_px", "u_right_std_px", "v_right_std_px"};

std::map<std::int64_t, RecordedPass> vehicles_of(const fs::path& file) {
  CsvReader csv(file, {"track_id", "direction", "status"});
  std::map<std::int64_t, RecordedPass> passes;
  while (csv.next()) {
    RecordedPass pass;
    const std::string_view status = csv.required_text("status");
    pass.sound = status == "measured" || status == "withheld:too_uncertain";
    pass.track.id = static_cast<int>(csv.integer("track_id"));
    const std::string_view direction = csv.required_text("direction");
    if (direction == name_of(Direction::receding)) {
      pass.track.direction = Direction::receding;
      pass.track.kind = LampKind::taillamp;
    } else if (direction != name_of(Direction::oncoming)) {
      csv.fail("direction", "\"" + std::string(direction) + "\" is not a direction",
               "write oncoming or receding");
    }
    passes.emplace(pass.track.id, std::move(pass));
  }
  return passes;
}

std::optional<LampSighting> lamp_of(const CsvReader& csv, const LampColumns& columns,
                                    const CameraSite& camera) {
  const auto u_px = csv.optional_number(columns.u_px);
  if (!u_px) return std::nullopt;
  LampSighting lamp;
  lamp.centre_px = {*u_px, csv.number(columns.v_px)};
  for (const auto& [column, place_px, size_px] :
       {std::tuple{columns.u_px, lamp.centre_px.x(), camera.width_px},
        {columns.v_px, lamp.centre_px.y(), camera.height_px}})
    if (!(place_px > -1.0 && place_px < size_px))
      csv.fail(column, "lies outside the site's image", "give the site file that the run used");
  const auto u_std_px = csv.optional_number(columns.u_std_px);
  if (u_std_px)
    lamp.centre_sigma_px = {*u_std_px, csv.number(columns.v_std_px)};
  else
    lamp.defects = Defect::cut_by_edge;
  lamp.row_fraction = (lamp.centre_px.y() + 0.5) / camera.height_px - 0.5;
  return lamp;
}

}  // namespace

std::vector<RecordedPass> read_recorded_passes(const fs::path& run_folder,
                                               const CameraSite& camera) {
  std::map<std::int64_t, RecordedPass> vehicles = vehicles_of(run_folder / "speeds.csv");
  CsvReader csv(run_folder / "tracks.csv",
                {"frame", "t_s", "track_id", kLeft.u_px, kLeft.v_px, kRight.u_px, kRight.v_px,
                 kLeft.u_std_px, kLeft.v_std_px, kRight.u_std_px, kRight.v_std_px});
  while (csv.next()) {
    const auto found = vehicles.find(csv.integer("track_id"));
    if (found == vehicles.end()) continue;
    VehicleSighting sighting;
    sighting.frame = csv.integer("frame");
    sighting.time = time_from_seconds<CameraTime>(csv.number("t_s"));
    auto& sightings = found->second.track.sightings;
    if (!sightings.empty() && sighting.frame <= sightings.back().frame)
      csv.fail("frame", "does not come after the track's frame before", "sort by frame");
    sighting.left = lamp_of(csv, kLeft, camera);
    sighting.right = lamp_of(csv, kRight, camera);
    if (sighting.left || sighting.right) sightings.push_back(sighting);
  }
  std::vector<RecordedPass> passes;
  for (auto& [id, pass] : vehicles)
    if (!pass.track.sightings.empty()) passes.push_back(std::move(pass));
  return passes;
}

void refuse_same_passes(std::span<const fs::path> folders,
                        std::span<const std::vector<VehicleTrack>> runs) {
  const auto places = [](const VehicleTrack& track) {
    std::vector<double> found;
    for (const VehicleSighting* seen : {&track.sightings.front(), &track.sightings.back()})
      for (const auto& lamp : {seen->left, seen->right})
        if (lamp) found.insert(found.end(), {lamp->centre_px.x(), lamp->centre_px.y()});
    return found;
  };
  const auto same = [&](const VehicleTrack& one, const VehicleTrack& other) {
    return one.sightings.size() == other.sightings.size() && places(one) == places(other);
  };
  for (std::size_t i = 0; i < runs.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const auto shared = std::ranges::count_if(runs[i], [&](const VehicleTrack& pass) {
        return std::ranges::any_of(runs[j],
                                   [&](const VehicleTrack& other) { return same(pass, other); });
      });
      if (shared == 0 ||
          2 * shared < std::ssize(runs[i].size() < runs[j].size() ? runs[i] : runs[j]))
        continue;
      throw ConfigError(
          {{folders[i].string(), 0, "",
            std::to_string(shared) + " of its passes are those of " + folders[j].string() +
                " to the last digit, as of one clip in two files; they would count "
                "twice",
            "name one run of each clip"}});
    }
}

}  // namespace vildar
