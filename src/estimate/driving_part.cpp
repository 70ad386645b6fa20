#include "estimate/driving_part.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "estimate/camera_view.h"

namespace vildar {
namespace {

constexpr double kStands_s = 1.2, kStands_m = 0.8, kLeastDriven_m = 5.0;
constexpr int kFewestFrames = 12;

struct Place {
  std::size_t sighting;
  double time_s, along_m, beside_m, along_sigma_m;
};

// In front of the camera and beside it, by the elevation of what is seen of the vehicle.
std::vector<Place> places_of(const VehicleTrack& track, const Camera& camera, const Site& site,
                             double over_lamps_m) {
  constexpr double kLeastDown_rad = 1e-3, kSigma_px = 0.3;
  const double sigma_rad = kSigma_px / camera.focal_px();
  std::vector<Place> places;
  const std::vector<TrackRow> rows = bearing_rows(track, camera, site);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const TrackRow& row = rows[i];
    const auto& lamp_rad = row.bearing_left_rad ? row.bearing_left_rad : row.bearing_right_rad;
    const auto& at_rad = row.bearing_rad ? row.bearing_rad : lamp_rad;
    if (!at_rad || -at_rad->y() < kLeastDown_rad) continue;
    const double along_m = over_lamps_m / std::tan(-at_rad->y()) * std::cos(at_rad->x());
    places.push_back({i, row.time_s, along_m, along_m * std::tan(at_rad->x()),
                      along_m * along_m / over_lamps_m * sigma_rad});
  }
  return places;
}

std::vector<char> stands(const std::vector<Place>& places) {
  constexpr double kSigmas = 4.0, kMostGap_s = 0.3;
  std::vector<char> found(places.size(), 0);
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (kSigmas * places[i].along_sigma_m > kStands_m) continue;
    const auto at_m = [&](std::size_t k) {
      return Eigen::Array2d(places[k].along_m, places[k].beside_m);
    };
    Eigen::Array2d least_m = at_m(i), most_m = least_m;
    std::size_t last = i;
    while (last + 1 < places.size() && places[last + 1].time_s - places[last].time_s < kMostGap_s) {
      least_m = least_m.min(at_m(last + 1));
      most_m = most_m.max(at_m(last + 1));
      if ((most_m - least_m).maxCoeff() > kStands_m) break;
      ++last;
      if (places[last].time_s - places[i].time_s < kStands_s) continue;
      std::fill(found.begin() + static_cast<std::ptrdiff_t>(i),
                found.begin() + static_cast<std::ptrdiff_t>(last) + 1, 1);
      break;
    }
  }
  return found;
}

}  // namespace

std::optional<VehicleTrack> driving_part(const VehicleTrack& track, const Camera& camera,
                                         const Site& site) {
  constexpr double kLeastOver_m = 1.0;
  if (site.ego || !site.camera || !site.lamps.height_m) return std::nullopt;
  const double over_lamps_m = site.camera->position_m[2].mean - site.lamps.height_m->mean;
  if (over_lamps_m < kLeastOver_m) return std::nullopt;
  const std::vector<Place> places = places_of(track, camera, site, over_lamps_m);
  const std::vector<char> standing = stands(places);
  if (std::ranges::find(standing, 1) == standing.end()) return std::nullopt;
  double most_m = kLeastDriven_m;
  std::size_t best_first = 0, best_end = 0;
  for (std::size_t first = 0; first < places.size(); ++first) {
    if (standing[first]) continue;
    std::size_t end = first;
    while (end < places.size() && !standing[end]) ++end;
    const double driven_m = std::abs(places[end - 1].along_m - places[first].along_m);
    if (driven_m > most_m && end - first >= kFewestFrames) {
      most_m = driven_m;
      best_first = first;
      best_end = end;
    }
    first = end;
  }
  if (best_end == 0) return std::nullopt;
  VehicleTrack part = track;
  const auto sighting = [&](std::size_t place) {
    return track.sightings.begin() + static_cast<std::ptrdiff_t>(places[place].sighting);
  };
  part.sightings.assign(sighting(best_first), sighting(best_end - 1) + 1);
  return part;
}

}  // namespace vildar
