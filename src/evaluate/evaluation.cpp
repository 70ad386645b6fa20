#include "evaluate/evaluation.h"

#include <algorithm>
#include <cmath>

#include "core/quantity.h"
#include "evaluate/frame_rates.h"
#include "evaluate/matching.h"

namespace vildar {
namespace {

using Fate = VehicleScore::Outcome;

struct SquareSum {
  double sum = 0.0;
  std::size_t count = 0;
  void add(double value) {
    sum += value * value;
    ++count;
  }
  std::optional<double> rms() const {
    if (count == 0) return std::nullopt;
    return std::sqrt(sum / static_cast<double>(count));
  }
};

double row_delay_s(const LampPixels& lamps, const EvaluateOptions& options) {
  if (!lamps.any()) return 0.0;
  const double row_fraction = (lamps.middle_px().y() + 0.5) / options.image_height_px - 0.5;
  return row_fraction * options.rolling_shutter_s;
}

void compare_places(const TruthVehicle& truth, const RunVehicle& run,
                    const EvaluateOptions& options, SquareSum& azimuth_rad, SquareSum& range_m) {
  std::map<std::int64_t, const TruthSighting*> by_frame;
  for (const TruthSighting& sighting : truth.sightings) by_frame.emplace(sighting.frame, &sighting);
  for (const RunSighting& sighting : run.sightings) {
    const auto found = by_frame.find(sighting.frame);
    if (found == by_frame.end()) continue;
    const TruthSighting& there = *found->second;
    const auto place_m = truth.place_at(there.t_s + row_delay_s(sighting.lamps, options));
    if (sighting.azimuth_rad && place_m) {
      const Eigen::Vector2d ray_m = *place_m - options.camera_xy_m;
      azimuth_rad.add(
          std::remainder(*sighting.azimuth_rad - std::atan2(ray_m.y(), ray_m.x()), 2.0 * kPi));
    }
    if (sighting.range_m && there.range_m) range_m.add(*sighting.range_m - *there.range_m);
  }
}

bool in_view(const TruthVehicle& vehicle, bool truth_has_pixels) {
  if (!truth_has_pixels) return !vehicle.sightings.empty();
  return std::ranges::any_of(vehicle.sightings,
                             [](const TruthSighting& sighting) { return sighting.visible(); });
}

bool has_pixels(const std::vector<TruthVehicle>& truth) {
  return std::ranges::any_of(truth, [](const TruthVehicle& vehicle) {
    return std::ranges::any_of(vehicle.sightings,
                               [](const TruthSighting& sighting) { return sighting.lamps.any(); });
  });
}

VehicleScore score_of(const TruthVehicle& truth, const RunVehicle& run) {
  VehicleScore score;
  score.vehicle_id = truth.id;
  score.lane = truth.lane;
  score.track_id = run.track_id;
  score.withheld = run.outcome.withheld;
  score.stated = run.outcome.speed;
  score.outcome = score.stated ? Fate::measured : Fate::withheld;
  if (score.stated) score.true_mps = truth.speed_at(score.stated->t_ref_s);
  score.wrong_direction =
      !truth.direction.empty() && !run.direction.empty() && truth.direction != run.direction;
  return score;
}

void score_methods(const RunVehicle& run, const TruthVehicle* truth,
                   std::map<std::string, MethodScore>& methods,
                   std::map<std::string, std::vector<SpeedPair>>& pairs) {
  for (const StatedMethod& stated : run.methods) {
    MethodScore& score = methods[stated.method];
    const std::optional<StatedSpeed>& speed = stated.outcome.speed;
    if (truth == nullptr) {
      if (speed) ++score.false_speeds;
    } else if (!speed) {
      ++score.withheld[stated.outcome.withheld];
    } else {
      ++score.measured;
      if (const auto true_mps = truth->speed_at(speed->t_ref_s))
        pairs[stated.method].push_back({*speed, *true_mps});
    }
  }
}

void count(Evaluation& result) {
  std::vector<SpeedPair> pairs;
  for (const VehicleScore& score : result.vehicles) {
    switch (score.outcome) {
      case Fate::measured:
        ++result.in_view, ++result.matched, ++result.measured;
        if (!score.true_mps) ++result.without_truth;
        break;
      case Fate::withheld:
        ++result.in_view, ++result.matched, ++result.withheld[score.withheld];
        break;
      case Fate::missed: ++result.in_view, ++result.missed; break;
      case Fate::not_in_view: ++result.not_in_view; break;
      case Fate::duplicate: ++result.false_speeds, ++result.duplicates; break;
      case Fate::false_speed: ++result.false_speeds; break;
    }
    result.wrong_direction += score.wrong_direction;
    if (score.outcome == Fate::measured)
      if (const auto pair = score.pair()) pairs.push_back(*pair);
  }
  result.speed = speed_statistics(pairs);
}

std::ptrdiff_t matched(const Matching& matching) {
  return std::ranges::count_if(matching.run_of_truth, [](const auto& run) { return !!run; });
}

}  // namespace

std::optional<SpeedPair> VehicleScore::pair() const {
  if (!stated || !true_mps) return std::nullopt;
  return SpeedPair{*stated, *true_mps};
}

Evaluation evaluate(const std::vector<TruthVehicle>& truth, const RunFolder& run,
                    const EvaluateOptions& options) {
  Evaluation result;
  result.notes = run.notes;
  Matching matching = match(truth, run.vehicles);
  const auto by_time = numbered_by_time(truth, run.vehicles);
  bool other_rate = false;
  if (by_time) {
    Matching then = match(truth, *by_time);
    other_rate = matched(then) > matched(matching);
    if (other_rate) matching = std::move(then);
  }
  const std::vector<RunVehicle>& vehicles = other_rate ? *by_time : run.vehicles;
  if (other_rate)
    result.notes.push_back(
        "the frames of the run have another rate than those of truth_tracks.csv: matched by time, "
        "tracking is not scored");
  result.matched_by_image = matching.by_image;
  const bool truth_has_pixels = has_pixels(truth);

  SquareSum azimuth_rad, range_m;
  std::map<std::string, std::vector<SpeedPair>> method_pairs;
  std::vector<const TruthVehicle*> truth_of_run(vehicles.size(), nullptr);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!matching.run_of_truth[i]) {
      VehicleScore& score = result.vehicles.emplace_back();
      score.vehicle_id = truth[i].id;
      score.lane = truth[i].lane;
      score.outcome = in_view(truth[i], truth_has_pixels) ? Fate::missed : Fate::not_in_view;
      continue;
    }
    const RunVehicle& vehicle = vehicles[*matching.run_of_truth[i]];
    truth_of_run[*matching.run_of_truth[i]] = &truth[i];
    VehicleScore& score = result.vehicles.emplace_back(score_of(truth[i], vehicle));
    SquareSum own_azimuth_rad, own_range_m;
    compare_places(truth[i], vehicle, options, own_azimuth_rad, own_range_m);
    score.azimuth_rms_rad = own_azimuth_rad.rms();
    score.range_rms_m = own_range_m.rms();
    compare_places(truth[i], vehicle, options, azimuth_rad, range_m);
  }
  for (std::size_t j = 0; j < vehicles.size(); ++j) {
    const RunVehicle& vehicle = vehicles[j];
    score_methods(vehicle, truth_of_run[j], result.methods, method_pairs);
    if (truth_of_run[j] != nullptr || !vehicle.outcome.speed) continue;
    VehicleScore& score = result.vehicles.emplace_back();
    score.track_id = vehicle.track_id;
    score.stated = vehicle.outcome.speed;
    score.outcome = Fate::false_speed;
    if (const auto of = matching.duplicate_of[j]) {
      score.outcome = Fate::duplicate;
      score.vehicle_id = truth[*of].id;
      score.lane = truth[*of].lane;
      score.true_mps = truth[*of].speed_at(vehicle.outcome.speed->t_ref_s);
    }
  }
  count(result);
  for (auto& [name, score] : result.methods) score.speed = speed_statistics(method_pairs[name]);
  result.azimuth_rms_rad = azimuth_rad.rms();
  result.range_rms_m = range_m.rms();
  if (!other_rate && (matching.by_image || (truth_has_pixels && vehicles.empty())))
    result.tracking = tracking_scores(tracking_frames(truth, vehicles));
  if (result.without_truth > 0)
    result.notes.push_back(std::to_string(result.without_truth) +
                           " measured speeds hold at a time that truth does not reach");
  return result;
}

std::string_view name_of(VehicleScore::Outcome outcome) {
  switch (outcome) {
    case Fate::measured: return "measured";
    case Fate::withheld: return "withheld";
    case Fate::missed: return "missed";
    case Fate::not_in_view: return "not_in_view";
    case Fate::false_speed: return "false";
    case Fate::duplicate: return "duplicate";
  }
  return "unknown";
}

}  // namespace vildar
