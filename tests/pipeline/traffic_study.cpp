// Random traffic, rendered, run end to end and scored: 24 scenes beside a general tracker on the
// same blobs, and further sets of 24 of other seeds.

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "capture/clip_source.h"
#include "config/site_file.h"
#include "detect/detector.h"
#include "evaluate/evaluation.h"
#include "evaluate/matching.h"
#include "evaluate/speed_statistics.h"
#include "optics/response.h"
#include "pipelines/run_pipeline.h"
#include "support/random_traffic.h"
#include "support/sort_baseline.h"
#include "synth/render.h"

namespace vildar {
namespace {

namespace fs = std::filesystem;

constexpr int kRounds = 2, kMostVehicles = 12;
constexpr std::uint64_t kFirstSeed = 7000;
constexpr double kNear_m = 80.0, kLong_s = 1.0;

struct Totals {
  int vehicles = 0, near_and_long = 0, found = 0, measured = 0, false_measured = 0, duplicates = 0;
  int wrong_direction = 0;
  std::vector<TrackingScores> own, sort_strict, sort_patient;
  std::vector<SpeedPair> speeds;

  void add(const Totals& other);
};

void Totals::add(const Totals& other) {
  vehicles += other.vehicles;
  near_and_long += other.near_and_long;
  found += other.found;
  measured += other.measured;
  false_measured += other.false_measured;
  duplicates += other.duplicates;
  wrong_direction += other.wrong_direction;
  own.insert(own.end(), other.own.begin(), other.own.end());
  sort_strict.insert(sort_strict.end(), other.sort_strict.begin(), other.sort_strict.end());
  sort_patient.insert(sort_patient.end(), other.sort_patient.begin(), other.sort_patient.end());
  speeds.insert(speeds.end(), other.speeds.begin(), other.speeds.end());
}

std::vector<BlobFrame> blobs_of(const fs::path& clip_path, const Site& site) {
  ClipSource clip(clip_path, {});
  Detector detector({}, Response(*site.camera), site.camera->exposure_s);
  std::vector<BlobFrame> frames;
  while (const auto frame = clip.next()) frames.push_back(detector.detect(*frame));
  return frames;
}

bool near_and_long(const TruthVehicle& vehicle, double frame_rate_hz) {
  const auto frames = std::ranges::count_if(vehicle.sightings, [](const TruthSighting& sighting) {
    return sighting.visible() && sighting.range_m && *sighting.range_m <= kNear_m;
  });
  return static_cast<double>(frames) >= kLong_s * frame_rate_hz;
}

void count(const Evaluation& evaluation, const std::vector<TruthVehicle>& truth,
           double frame_rate_hz, const std::string& scene, Totals& totals) {
  for (const VehicleScore& score : evaluation.vehicles) {
    const auto of = std::ranges::find(truth, score.vehicle_id, &TruthVehicle::id);
    const bool counts = of != truth.end() && near_and_long(*of, frame_rate_hz);
    const auto tell = [&](const char* what) {
      std::printf("%s: vehicle %s, track %s: %s\n", scene.c_str(), score.vehicle_id.c_str(),
                  score.track_id.c_str(), what);
    };
    totals.wrong_direction += score.wrong_direction;
    switch (score.outcome) {
      case VehicleScore::Outcome::not_in_view: continue;
      case VehicleScore::Outcome::false_speed:
        ++totals.false_measured;
        tell("a speed of nothing");
        continue;
      case VehicleScore::Outcome::duplicate:
        ++totals.false_measured, ++totals.duplicates;
        tell("a second speed");
        continue;
      case VehicleScore::Outcome::missed:
        if (counts) tell("missed");
        break;
      case VehicleScore::Outcome::withheld: totals.found += counts; break;
      case VehicleScore::Outcome::measured:
        totals.found += counts;
        ++totals.measured;
        if (const auto speed = score.pair()) totals.speeds.push_back(*speed);
        break;
    }
    ++totals.vehicles;
    totals.near_and_long += counts;
  }
  if (evaluation.tracking && evaluation.tracking->clear.id_switches > 0)
    std::printf("%s: %lld identity switches\n", scene.c_str(),
                static_cast<long long>(evaluation.tracking->clear.id_switches));
}

double print_tracks(const char* name, const std::vector<TrackingScores>& scenes) {
  const TrackingScores scores = combined(scenes);
  const double hota = mean_of(scores.hota.hota());
  std::printf("%-22s HOTA %.3f DetA %.3f AssA %.3f MOTA %.3f IDF1 %.3f switches %lld\n", name, hota,
              mean_of(scores.hota.detection_accuracy()), mean_of(scores.hota.association_accuracy),
              scores.clear.mota(), scores.identity.idf1(),
              static_cast<long long>(scores.clear.id_switches));
  return hota;
}

double print(const std::string& name, const Totals& totals) {
  std::vector<double> error_percent;
  for (const SpeedPair& speed : totals.speeds)
    if (const auto error = speed.error_percent()) error_percent.push_back(std::abs(*error));
  std::ranges::sort(error_percent);
  const auto quantile = [&](double share) {
    return error_percent.at(
        static_cast<std::size_t>(share * static_cast<double>(error_percent.size() - 1)));
  };
  const auto inside = std::ranges::count_if(
      totals.speeds, [](const SpeedPair& speed) { return speed.inside_95().value_or(false); });
  const auto far_off = std::ranges::count_if(totals.speeds, [](const SpeedPair& speed) {
    return std::abs(speed.z().value_or(0.0)) > 3.0;
  });
  const auto tenth_off = std::ranges::count_if(error_percent, [](double e) { return e > 10.0; });
  std::printf(
      "%s: %d vehicles, %d of them a second or more within 80 m, of these %d found; %d measured, "
      "false %d (second speeds %d), wrong way %d; speed off by %.1f %% (median), %.1f %% (95 of "
      "100); of %zu inside 95 %% %td, off by more than 3 sigmas %td, by more than 10 %% %td\n",
      name.c_str(), totals.vehicles, totals.near_and_long, totals.found, totals.measured,
      totals.false_measured, totals.duplicates, totals.wrong_direction, quantile(0.5),
      quantile(0.95), totals.speeds.size(), inside, far_off, tenth_off);
  return print_tracks("vildar", totals.own);
}

struct TrafficSet {
  std::uint64_t first_seed = kFirstSeed;
  bool wet = false;
  bool beside_sort = false;

  std::string name() const { return (wet ? "wet " : "dry ") + std::to_string(first_seed); }
};

Totals scored(const TrafficSet& traffic) {
  Totals totals;
  for (int round = 0; round < kRounds; ++round) {
    for (int vehicles = 1; vehicles <= kMostVehicles; ++vehicles) {
      const int number = round * kMostVehicles + vehicles;
      const Scenario scene = random_traffic(traffic.first_seed + static_cast<std::uint64_t>(number),
                                            vehicles, traffic.wet);
      const fs::path folder =
          fs::path(::testing::TempDir()) / ("vildar_traffic_" + std::to_string(::getpid()));
      render(scene, folder, [](std::int64_t, std::int64_t) {});
      RunOptions options;
      options.clip = folder / "clip.mp4";
      options.site = folder / "site.yaml";
      options.out = folder / "run";
      run_pipeline(options);
      const std::vector<TruthVehicle> truth = read_truth_folder(folder);
      const Evaluation evaluation = evaluate(truth, read_run_folder(options.out));
      count(evaluation, truth, scene.frame_rate_hz, traffic.name() + " + " + std::to_string(number),
            totals);
      if (evaluation.tracking) totals.own.push_back(*evaluation.tracking);
      if (traffic.beside_sort) {
        const Site site = load_site(folder / "site.yaml");
        const std::vector<BlobFrame> blobs = blobs_of(*options.clip, site);
        const RoadView view(site);
        for (const bool patient : {false, true}) {
          const int max_age = patient ? static_cast<int>(0.7 * scene.frame_rate_hz) : 1;
          (patient ? totals.sort_patient : totals.sort_strict)
              .push_back(
                  tracking_scores(tracking_frames(truth, sort_baseline(blobs, view, max_age))));
        }
      }
      fs::remove_all(folder);
    }
  }
  return totals;
}

void study(bool wet) {
  const TrafficSet traffic{.wet = wet, .beside_sort = true};
  const Totals totals = scored(traffic);
  const double own = print(traffic.name(), totals);
  const double strict = print_tracks("SORT, max_age 1", totals.sort_strict);
  const double patient = print_tracks("SORT, max_age 0.7 s", totals.sort_patient);

  EXPECT_GE(totals.found, 0.99 * totals.near_and_long);
  EXPECT_EQ(totals.false_measured, 0);
  EXPECT_LE(100 * combined(totals.own).clear.id_switches, totals.vehicles);
  EXPECT_GT(own, std::max(strict, patient));
}

TEST(Traffic, DryRoad) { study(false); }
TEST(Traffic, WetRoad) { study(true); }

/// Sets of further seeds, one after the other and taken together.
Totals other_seeds(bool wet, std::initializer_list<std::uint64_t> first_seeds) {
  Totals all;
  for (const std::uint64_t first_seed : first_seeds) {
    const TrafficSet traffic{.first_seed = first_seed, .wet = wet};
    const Totals totals = scored(traffic);
    print(traffic.name(), totals);
    all.add(totals);
  }
  print(wet ? "wet, other seeds" : "dry, other seeds", all);
  return all;
}

TEST(Traffic, DryRoadOtherSeeds) {
  const Totals all = other_seeds(false, {9000, 15000});
  EXPECT_GE(all.found, 0.99 * all.near_and_long);
  EXPECT_EQ(all.false_measured, 0);
  EXPECT_LE(100 * combined(all.own).clear.id_switches, all.vehicles);
}

// One switch in 80 vehicles is what is reached in all of these, one in 100 with all others:
// docs/tracking.md tells why.
TEST(Traffic, WetRoadOtherSeeds) {
  const Totals all =
      other_seeds(true, {9000, 15000, 23000, 31000, 41000, 53000, 67000, 79000, 83000});
  EXPECT_GE(all.found, 0.99 * all.near_and_long);
  EXPECT_EQ(all.false_measured, 0);
  EXPECT_LE(80 * combined(all.own).clear.id_switches, all.vehicles);
}

}  // namespace
}  // namespace vildar
