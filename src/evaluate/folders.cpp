#include "evaluate/folders.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "evaluate/csv_reader.h"

namespace vildar {
namespace {

using IndexOf = std::map<std::string, std::size_t, std::less<>>;

std::optional<Eigen::Vector2d> pixel(const CsvReader& csv, std::string_view u_column,
                                     std::string_view v_column) {
  const std::optional<double> u_px = csv.optional_number(u_column);
  const std::optional<double> v_px = csv.optional_number(v_column);
  if (u_px.has_value() != v_px.has_value())
    csv.fail(u_px ? v_column : u_column, "is empty although its partner is not",
             "give both coordinates of a lamp, or neither");
  if (!u_px) return std::nullopt;
  return Eigen::Vector2d(*u_px, *v_px);
}

LampPixels lamp_pixels(const CsvReader& csv) {
  return {pixel(csv, "u_left_px", "v_left_px"), pixel(csv, "u_right_px", "v_right_px")};
}

StatedOutcome outcome_of(const CsvReader& csv) {
  constexpr std::string_view kWithheld = "withheld:";
  const std::string_view status = csv.required_text("status");
  StatedOutcome outcome;
  if (status == "measured") {
    outcome.speed = {csv.number("t_ref_s"), csv.number("speed_mps"),
                     csv.optional_number("speed_std_mps"), csv.optional_number("speed_lo95_mps"),
                     csv.optional_number("speed_hi95_mps")};
    const StatedSpeed& speed = *outcome.speed;
    if (speed.std_mps && !(*speed.std_mps > 0.0))
      csv.fail("speed_std_mps", "must be positive", "leave the cell empty where it is unknown");
    if (speed.lo95_mps && speed.hi95_mps && *speed.lo95_mps > *speed.hi95_mps)
      csv.fail("speed_hi95_mps", "is below speed_lo95_mps", "exchange the two");
  } else if (status.starts_with(kWithheld) && status.size() > kWithheld.size()) {
    outcome.withheld = status.substr(kWithheld.size());
  } else {
    csv.fail("status", "\"" + std::string(status) + "\" is not a status",
             "write measured or withheld:REASON");
  }
  return outcome;
}

void read_speeds(const std::filesystem::path& file, RunFolder& run, IndexOf& index) {
  CsvReader csv(file, {"track_id", "status", "t_first_s", "t_last_s", "t_ref_s", "speed_mps"});
  while (csv.next()) {
    RunVehicle vehicle;
    vehicle.track_id = csv.required_text("track_id");
    if (!index.emplace(vehicle.track_id, run.vehicles.size()).second)
      csv.fail("track_id", vehicle.track_id + " stands in an earlier row", "one row per vehicle");
    vehicle.direction = csv.text("direction");
    vehicle.outcome = outcome_of(csv);
    if (vehicle.outcome.speed && vehicle.outcome.speed->speed_mps < 0.0)
      csv.fail("speed_mps", "is negative", "the way it goes stands in the column direction");
    vehicle.t_first_s = csv.number("t_first_s");
    vehicle.t_last_s = csv.number("t_last_s");
    if (vehicle.t_last_s < vehicle.t_first_s)
      csv.fail("t_last_s", "is before t_first_s", "exchange the two");
    vehicle.range_ref_m = csv.optional_number("range_ref_m");
    run.vehicles.push_back(std::move(vehicle));
  }
}

void read_tracks(const std::filesystem::path& file, RunFolder& run, IndexOf& index) {
  CsvReader csv(file,
                {"frame", "t_s", "track_id", "u_left_px", "v_left_px", "u_right_px", "v_right_px"});
  std::set<std::pair<std::int64_t, std::size_t>> seen;
  while (csv.next()) {
    const std::string id(csv.required_text("track_id"));
    const double t_s = csv.number("t_s");
    const auto [entry, is_new] = index.emplace(id, run.vehicles.size());
    if (is_new) {
      RunVehicle vehicle;
      vehicle.track_id = id;
      vehicle.outcome.withheld = "not_in_speeds_csv";
      vehicle.t_first_s = vehicle.t_last_s = t_s;
      run.vehicles.push_back(std::move(vehicle));
      run.notes.push_back("track " + id + " of tracks.csv has no row in speeds.csv");
    }
    const std::int64_t frame = csv.integer("frame");
    if (!seen.emplace(frame, entry->second).second)
      csv.fail("frame", "track " + id + " has an earlier row for frame " + std::to_string(frame),
               "one row per vehicle and frame");
    RunVehicle& vehicle = run.vehicles[entry->second];
    if (is_new || vehicle.outcome.withheld == "not_in_speeds_csv") {
      vehicle.t_first_s = std::min(vehicle.t_first_s, t_s);
      vehicle.t_last_s = std::max(vehicle.t_last_s, t_s);
    }
    vehicle.sightings.push_back({frame, lamp_pixels(csv), csv.optional_number("azimuth_rad"),
                                 csv.optional_number("range_m"), t_s});
  }
  for (RunVehicle& vehicle : run.vehicles)
    std::ranges::sort(vehicle.sightings, {}, &RunSighting::frame);
}

void read_methods(const std::filesystem::path& file, RunFolder& run, const IndexOf& index) {
  CsvReader csv(file, {"track_id", "method", "status", "t_ref_s", "speed_mps"});
  while (csv.next()) {
    const auto found = index.find(csv.required_text("track_id"));
    if (found == index.end())
      csv.fail("track_id", std::string(csv.text("track_id")) + " is not in speeds.csv",
               "the files must come from the same run");
    std::vector<StatedMethod>& methods = run.vehicles[found->second].methods;
    const std::string method(csv.required_text("method"));
    if (std::ranges::find(methods, method, &StatedMethod::method) != methods.end())
      csv.fail("method", method + " stands in an earlier row of this track",
               "one row per vehicle and method");
    methods.push_back({method, outcome_of(csv)});
  }
}

void read_truth_tracks(const std::filesystem::path& file, std::vector<TruthVehicle>& vehicles,
                       const IndexOf& index) {
  CsvReader csv(
      file, {"frame", "t_s", "vehicle_id", "u_left_px", "v_left_px", "u_right_px", "v_right_px"});
  std::set<std::pair<std::int64_t, std::size_t>> seen;
  while (csv.next()) {
    const auto found = index.find(csv.required_text("vehicle_id"));
    if (found == index.end())
      csv.fail("vehicle_id", std::string(csv.text("vehicle_id")) + " is not in truth_vehicles.csv",
               "add the vehicle there");
    TruthSighting sighting;
    sighting.frame = csv.integer("frame");
    if (!seen.emplace(sighting.frame, found->second).second)
      csv.fail("frame", "the vehicle has an earlier row for this frame",
               "one row per vehicle and frame");
    sighting.t_s = csv.number("t_s");
    sighting.lamps = lamp_pixels(csv);
    sighting.x_m = csv.optional_number("x_m");
    sighting.y_m = csv.optional_number("y_m");
    sighting.range_m = csv.optional_number("range_m");
    sighting.speed_mps = csv.optional_number("speed_mps");
    const std::string_view occluded = csv.text("occluded");
    if (!occluded.empty() && occluded != "0" && occluded != "1")
      csv.fail("occluded", "\"" + std::string(occluded) + "\" is neither 0 nor 1", "write 0 or 1");
    sighting.occluded = occluded == "1";
    vehicles[found->second].sightings.push_back(sighting);
  }
  for (TruthVehicle& vehicle : vehicles)
    std::ranges::sort(vehicle.sightings, {}, &TruthSighting::t_s);
}

// Straight between the neighbours that state the quantity.
std::optional<double> interpolated(const std::vector<TruthSighting>& sightings, double t_s,
                                   std::optional<double> TruthSighting::*quantity) {
  const TruthSighting* before = nullptr;
  for (const TruthSighting& sighting : sightings) {
    if (!(sighting.*quantity)) continue;
    if (sighting.t_s == t_s) return sighting.*quantity;
    if (sighting.t_s > t_s) {
      if (before == nullptr) return std::nullopt;
      const double part = (t_s - before->t_s) / (sighting.t_s - before->t_s);
      return std::lerp(*(before->*quantity), *(sighting.*quantity), part);
    }
    before = &sighting;
  }
  return std::nullopt;
}

}  // namespace

RunFolder read_run_folder(const std::filesystem::path& folder) {
  RunFolder run;
  IndexOf index;
  read_speeds(folder / "speeds.csv", run, index);
  if (std::filesystem::exists(folder / "tracks.csv"))
    read_tracks(folder / "tracks.csv", run, index);
  else
    run.notes.push_back(
        "the run has no tracks.csv: vehicles are matched by time, tracking is not scored");
  if (std::filesystem::exists(folder / "methods.csv"))
    read_methods(folder / "methods.csv", run, index);
  else
    run.notes.push_back("the run has no methods.csv: methods are not scored");
  return run;
}

std::optional<double> TruthVehicle::speed_at(double t_s) const {
  if (const auto speed = interpolated(sightings, t_s, &TruthSighting::speed_mps)) return speed;
  if (t_s == t_ref_s) return speed_mps;
  if (!acceleration_mps2) return std::nullopt;
  return speed_mps + *acceleration_mps2 * (t_s - t_ref_s);
}

std::optional<double> TruthVehicle::range_at(double t_s) const {
  return interpolated(sightings, t_s, &TruthSighting::range_m);
}

std::optional<Eigen::Vector2d> TruthVehicle::place_at(double t_s) const {
  const auto x_m = interpolated(sightings, t_s, &TruthSighting::x_m);
  const auto y_m = interpolated(sightings, t_s, &TruthSighting::y_m);
  if (!x_m || !y_m) return std::nullopt;
  return Eigen::Vector2d(*x_m, *y_m);
}

std::vector<TruthVehicle> read_truth_folder(const std::filesystem::path& folder) {
  std::vector<TruthVehicle> vehicles;
  IndexOf index;
  CsvReader csv(folder / "truth_vehicles.csv", {"vehicle_id", "t_ref_s", "speed_mps"});
  while (csv.next()) {
    TruthVehicle vehicle;
    vehicle.id = csv.required_text("vehicle_id");
    if (!index.emplace(vehicle.id, vehicles.size()).second)
      csv.fail("vehicle_id", vehicle.id + " stands in an earlier row", "one row per vehicle");
    vehicle.direction = csv.text("direction");
    vehicle.lane = csv.text("lane");
    vehicle.t_ref_s = csv.number("t_ref_s");
    vehicle.speed_mps = csv.number("speed_mps");
    if (vehicle.speed_mps < 0.0)
      csv.fail("speed_mps", "is negative", "a speed is a magnitude; say the direction apart");
    vehicle.acceleration_mps2 = csv.optional_number("acceleration_mps2");
    vehicles.push_back(std::move(vehicle));
  }
  read_truth_tracks(folder / "truth_tracks.csv", vehicles, index);
  return vehicles;
}

}  // namespace vildar
