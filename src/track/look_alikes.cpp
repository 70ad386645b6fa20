#include "track/look_alikes.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Geometry>

#include "track/standing.h"
#include "track/vehicle_body.h"

namespace vildar {
namespace {

constexpr int kMemory = 12;  // frames

double inverse_depth_of(const Lamp& lamp) {
  const Vehicle* vehicle = lamp.vehicle;
  return vehicle && vehicle->left && vehicle->right ? vehicle->inverse_depth_per_m
                                                    : lamp.place().inverse_depth_per_m;
}

// Does `lamp` move as a point that stays at its offset from `reference` in the world?
bool moves_with(const Lamp& lamp, const Lamp& reference) {
  constexpr double kSigmas = 3.0, kGive_pxps = 8.0, kRateGive_per_s = 0.25;
  const Eigen::Vector2d off_px = lamp.at_px() - reference.at_px();
  const Eigen::Vector2d expected_pxps =
      reference.velocity_pxps() - reference.depth_rate_per_s() * off_px;
  const double give_pxps =
      kGive_pxps +
      kSigmas * std::hypot(lamp.velocity_sigma_pxps(), reference.velocity_sigma_pxps()) +
      (kRateGive_per_s + 0.3 * std::abs(reference.depth_rate_per_s())) * off_px.norm();
  return (lamp.velocity_pxps() - expected_pxps).norm() < give_pxps;
}

double log_flux_per_px(const Lamp& lamp) {
  const PixelBox& box = lamp.records.back().sighting.box;
  return lamp.log_flux() - std::log((box.u_max - box.u_min + 1.0) * (box.v_max - box.v_min + 1.0));
}

// Height over width.
double slenderness(const Lamp& lamp) {
  const PixelBox& box = lamp.records.back().sighting.box;
  return (box.v_max - box.v_min + 1.0) / (box.u_max - box.u_min + 1.0);
}

// How many lamp heights `lamp` stands below `source`, where it is in its column, no brighter, and
// moves along with it. An image that the road draws out may have more light, but not for its size.
std::optional<double> heights_below(const Lamp& lamp, const Lamp& source, const RoadView& view) {
  constexpr double kColumn_m = 0.2, kColumn_px = 1.5, kBrighterLn = 0.3, kDrawnOut = 1.2;
  // Of clipped lights the larger one, not the stronger one, seems brighter.
  const bool clipped = lamp.records.back().sighting.saturated_px > 0 &&
                       source.records.back().sighting.saturated_px > 0;
  const bool drawn_out = slenderness(lamp) > kDrawnOut * slenderness(source) &&
                         log_flux_per_px(lamp) < log_flux_per_px(source);
  if (!clipped && !drawn_out && lamp.log_flux() > source.log_flux() + kBrighterLn)
    return std::nullopt;
  const double inverse_depth = inverse_depth_of(source);
  const Eigen::Vector2d off_px = lamp.at_px() - source.at_px();
  const Eigen::Vector2d down_px = source.place().down_px;
  const double drop_px = off_px.dot(down_px) / down_px.norm();
  if (!(drop_px > 1.0)) return std::nullopt;
  const double column_px = (off_px - down_px.normalized() * drop_px).norm();
  if (column_px > kColumn_px + kColumn_m * inverse_depth * view.focal_px()) return std::nullopt;
  if (!moves_with(lamp, source)) return std::nullopt;
  return drop_px / (down_px.norm() * inverse_depth) / view.lamp_height_m();
}

// Taller and fainter than the lamp above it, where a nearer one would be brighter.
bool is_drawn_out(const Lamp& lamp, const Lamp& source) {
  constexpr double kTaller = 1.5, kFainterLn = 0.5;
  return slenderness(lamp) > kTaller * slenderness(source) &&
         lamp.log_flux() < source.log_flux() - kFainterLn;
}

constexpr double kHighCamera_m = 2.0;
constexpr double kNearestImage = 0.7, kLongestStreak = 5.0, kFarthestGlint = 8.0;  // lamp heights

// A wet or smooth road shows a lamp at height h again at -h: same column, fainter, moving along.
// A rough road draws the image out toward the viewer and fills it up to the lamp.
bool mirrors(const Lamp& lamp, const Lamp& source, const RoadView& view) {
  constexpr double kNearerPair = 1.15;
  // A nearer vehicle's lamps stand wider apart than the mirror image of a farther one's.
  if (lamp.vehicle && source.vehicle) {
    const double ratio = lamp.vehicle->width_per_depth / source.vehicle->width_per_depth;
    if (lamp.vehicle == source.vehicle || ratio > kNearerPair || ratio < 1.0 / kNearerPair)
      return false;
  }
  constexpr double kNearestHigh = 1.4, kFarthestHigh = 2.8, kFarthestDrawnOut = 3.3;
  const auto heights = heights_below(lamp, source, view);
  if (!heights) return false;
  if (view.height_over_lamps_m() <= kHighCamera_m)
    return *heights > kNearestImage && *heights < kLongestStreak;
  return *heights > kNearestHigh &&
         *heights < (is_drawn_out(lamp, source) ? kFarthestDrawnOut : kFarthestHigh);
}

// Drops and waves show a lamp again all along its column.
bool may_glint_of(const Lamp& lamp, const Lamp& source, const RoadView& view) {
  const auto heights = heights_below(lamp, source, view);
  return heights && *heights > kNearestImage && *heights < kFarthestGlint;
}

// Are the lamps of `lower` the far end of the streaks that the lamps of `source` draw on the road?
// They stand as far apart in the image as those, where a vehicle's would be `nearer` times as far,
// which its separation tells only where that is much.
bool is_image_of(const Vehicle& lower, const Vehicle& source, const RoadView& view,
                 std::int64_t frame) {
  constexpr double kTold = 1.3;  // two standard deviations of two separations
  constexpr double kToldDrawnOut = 1.1;
  const double nearer = lower.inverse_depth_per_m / source.inverse_depth_per_m;
  const double ratio = lower.width_per_depth / source.width_per_depth;
  const auto drawn_out = [&](const Lamp& lamp, const Lamp& above) {
    return lamp.seen_at(frame) && is_drawn_out(lamp, above);
  };
  const bool both = drawn_out(*lower.left, *source.left) && drawn_out(*lower.right, *source.right);
  if (!(nearer > (both ? kToldDrawnOut : kTold) && ratio * ratio < nearer &&
        ratio * ratio > 1.0 / nearer))
    return false;
  const auto below = [&](const Lamp& lamp, const Lamp& above) {
    if (!lamp.seen_at(frame)) return true;
    const auto heights = heights_below(lamp, above, view);
    return heights && *heights < kLongestStreak;
  };
  return below(*lower.left, *source.left) && below(*lower.right, *source.right);
}

// Number plate, bonnet, fog lamp, roof: on a vehicle that has its lamps.
bool rides_on(const Lamp& lamp, const Vehicle& vehicle, const RoadView& view) {
  return stands_within_body(lamp, vehicle, view) &&
         (moves_with(lamp, *vehicle.left) || moves_with(lamp, *vehicle.right)) &&
         !changes_place_on_body(lamp, vehicle, view);
}

// What a vehicle lights before itself, road or paint, moves along with it, and is wider or far
// fainter than a lamp would be there.
bool lit_by(const Lamp& lamp, const Lamp& source, const RoadView& view) {
  constexpr double kNearest_m = 1.0, kFarthest_m = 22.0, kBeside_m = 1.8;
  constexpr double kWider = 1.4, kFainterLn = 2.0;
  const double height_m = view.height_over_lamps_m() + view.lamp_height_m();
  if (view.height_over_lamps_m() < kHighCamera_m || source.kind() == LampKind::taillamp)
    return false;
  const auto width_px = [](const Lamp& one) {
    const PixelBox& box = one.records.back().sighting.box;
    return box.u_max - box.u_min + 1.0;
  };
  const double source_inverse_depth = inverse_depth_of(source);
  const double road_inverse_depth = lamp.place().slope_down / height_m;
  if (!(road_inverse_depth > source_inverse_depth)) return false;
  const RoadPosition lit = view.road_at(lamp.at_px(), road_inverse_depth);
  const RoadPosition from = view.road_at(source.at_px(), source_inverse_depth);
  const double before_m = from.along_m - lit.along_m;
  if (before_m < kNearest_m || before_m > kFarthest_m) return false;
  if (std::abs(lit.lateral_m - from.lateral_m) > kBeside_m) return false;
  const double nearer = road_inverse_depth / source_inverse_depth;
  const bool wide = width_px(lamp) >= kWider * nearer * width_px(source);
  const bool faint = lamp.log_flux() - 2.0 * std::log(nearer) < source.log_flux() - kFainterLn;
  return (wide || faint) && moves_with(lamp, source);
}

// A streak is followed at its middle, and where its lamp was not known at its top.
bool is_within(const Eigen::Vector2d& at_px, const Spot& spot) {
  constexpr double kMargin_px = 1.0;
  const PixelBox& box = spot.blob->box;
  const Eigen::Array2d half_px(0.5 * (box.u_max - box.u_min + 1.0),
                               0.5 * (box.v_max - box.v_min + 1.0));
  return ((at_px - spot.at_px).array().abs() <= half_px + kMargin_px).all();
}

}  // namespace

void note_look_alikes(const Lamps& lamps, const std::vector<Spot>& spots, const Vehicles& vehicles,
                      const RoadView& view, std::int64_t frame, bool sways) {
  constexpr double kAboveSigmas = 2.5;
  for (const auto& lamp : lamps) {
    if (!lamp->seen_at(frame)) {
      if (!lamp->vehicle && std::ranges::any_of(spots, [&](const Spot& spot) {
            return spot.streak && is_within(lamp->at_px(), spot);
          }))
        lamp->reflected.add(true, kMemory);
      continue;
    }
    const LampPlace at = view.place(lamp->at_px());
    const double least = std::min(0.0, view.height_over_lamps_m() * at.inverse_depth_per_m);
    lamp->above.add(at.slope_down < least - kAboveSigmas * view.slope_sigma(at.inverse_depth_per_m),
                    kMemory);
    lamp->fixed = stands_in_the_world(*lamp, lamps, view, sways);
    const bool mirrored = std::any_of(lamps.begin(), lamps.end(), [&](const auto& source) {
      return source != lamp && source->seen_at(frame) && mirrors(*lamp, *source, view);
    });
    const bool image = mirrored || lamp->records.back().streak;
    lamp->mirrored.add(image, kMemory);
    lamp->reflected.add(image, kMemory);
    if (mirrored) lamp->records.back().casts_image = false;  // both are parts of one streak
    if (lamp->vehicle) continue;
    const bool below = !mirrored && std::ranges::any_of(lamps, [&](const auto& source) {
      return source != lamp && source->seen_at(frame) && may_glint_of(*lamp, *source, view);
    });
    lamp->below.add(below, kMemory);
    const bool lit = std::any_of(lamps.begin(), lamps.end(), [&](const auto& source) {
      return source != lamp && source->seen_at(frame) && source->mirrored.share() < 0.5 &&
             source->on_vehicle.share() < 0.5 && lit_by(*lamp, *source, view);
    });
    const bool riding = std::any_of(vehicles.begin(), vehicles.end(), [&](const auto& vehicle) {
      return vehicle->left && vehicle->right && rides_on(*lamp, *vehicle, view);
    });
    lamp->on_vehicle.add(riding || lit, kMemory);
  }
  const auto both_seen = [frame](const auto& vehicle) {
    return vehicle->left && vehicle->right && vehicle->left->seen_at(frame) &&
           vehicle->right->seen_at(frame);
  };
  for (const auto& vehicle : vehicles) {
    if (!vehicle->left || !vehicle->right ||
        !(vehicle->left->seen_at(frame) || vehicle->right->seen_at(frame)))
      continue;
    ++vehicle->looks;
    vehicle->images += std::ranges::any_of(vehicles, [&](const auto& source) {
      return source != vehicle && both_seen(source) && is_image_of(*vehicle, *source, view, frame);
    });
  }
}

}  // namespace vildar
