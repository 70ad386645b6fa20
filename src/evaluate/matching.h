#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "evaluate/folders.h"
#include "evaluate/tracking_metrics.h"

namespace vildar {

/// How well two sightings of lamps agree: 1 - min(1, distance / scale). The distance is that of the
/// middles of the pairs; where the run saw one lamp alone, its distance to the nearer lamp of the
/// truth. The scale is the true separation of the lamps in the image, at least 10 px, so that a
/// run counts as on the vehicle (0.5) while it is off by less than half the vehicle's lamp width.
/// 0 where either shows no lamp.
double lamp_similarity(const LampPixels& truth, const LampPixels& run);

struct Matching {
  /// By index of the truth vehicle; what is absent was missed.
  std::vector<std::optional<std::size_t>> run_of_truth;
  /// By index of the run vehicle: the truth vehicle that it shows, of those that another track was
  /// matched to (a vehicle counted twice).
  std::vector<std::optional<std::size_t>> duplicate_of;
  bool by_image = false;  ///< otherwise by time alone
};

/// One-to-one, of the largest total agreement. By image position: the agreement is the sum of
/// lamp_similarity over the frames in which both are visible; a pair whose mean is below 0.5, or
/// that shares fewer than half the frames of the shorter of the two, is not matched. Where the
/// track matched so has no speed and another one of the same vehicle has, that one is matched in
/// its place (of several the one that agrees best). Run vehicles without pixels (photodiode) are
/// matched to the truth left over by time: the agreement is the share of the run's time in which
/// the vehicle is there (at least half), less where its moment of passing (oncoming: its end,
/// receding: its beginning), its direction or its range does not fit.
Matching match(std::span<const TruthVehicle> truth, std::span<const RunVehicle> run);

/// Frame by frame for tracking_scores(), ids being indices. Truth that is occluded is not asked
/// for, and a sighting of the run that matches it counts neither way.
std::vector<TrackingFrame> tracking_frames(std::span<const TruthVehicle> truth,
                                           std::span<const RunVehicle> run);

}  // namespace vildar
