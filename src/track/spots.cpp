#include "track/spots.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/quantity.h"

namespace vildar {
namespace {

double width_px(const PixelBox& box) { return box.u_max - box.u_min + 1.0; }
double height_px(const PixelBox& box) { return box.v_max - box.v_min + 1.0; }

bool is_drawn_out(const Blob& blob) {
  constexpr double kTall = 1.6, kLeast_px = 8.0;
  return blob.kind != LampKind::taillamp && height_px(blob.box) >= kLeast_px &&
         height_px(blob.box) > kTall * width_px(blob.box);
}

// Before a high camera the elevation of a lamp says how large a metre is there, and its mirror
// image stands as far below the road as the lamp above it. Undistorted pixels; nothing from low
// down.
std::optional<double> mirror_drop_px(const Blob& lamp, const RoadView& view) {
  constexpr double kHighCamera_m = 2.0;
  if (view.height_over_lamps_m() < kHighCamera_m) return std::nullopt;
  const auto at_px = view.spot_from_pixel(lamp.centre_px);
  if (!at_px) return std::nullopt;
  const LampPlace at = view.place(*at_px);
  return 2.0 * view.lamp_height_m() * at.inverse_depth_per_m * at.down_px.norm();
}

// A light in the same column whose own mirror image the streak could be: no farther above it than
// the streak is long a few times over, and with the image about the middle of the streak.
bool shines_above(const Blob& lamp, const Blob& streak, const RoadView& view) {
  constexpr double kColumnShare = 0.8, kColumn_px = 1.5, kReach = 3.0, kMostDrops = 1.6;
  if (&lamp == &streak || lamp.kind == LampKind::other) return false;
  const double off_px = std::abs(lamp.centre_px.x() - streak.centre_px.x());
  if (off_px > kColumn_px + kColumnShare * width_px(streak.box)) return false;
  const double gap_px = streak.box.v_min - lamp.centre_px.y();
  if (gap_px < -0.5 * width_px(streak.box) || gap_px > kReach * height_px(streak.box)) return false;
  const auto drop_px = mirror_drop_px(lamp, view);
  return !drop_px || gap_px + 0.5 * height_px(streak.box) < kMostDrops * *drop_px;
}

// Light right below a lamp, in its columns and all but touching: its image on a wet road, cut off
// where the two are dimmest together, leaves a part with the lamp.
bool hangs_below(const Blob& light, const Blob& lamp) {
  constexpr double kTouch_px = 2.0;
  if (&light == &lamp) return false;
  const double gap_px = light.box.v_min - lamp.box.v_max - 1.0;
  return gap_px >= -1.0 && gap_px <= kTouch_px && light.box.u_min <= lamp.centre_px.x() &&
         lamp.centre_px.x() <= light.box.u_max;
}

// Headlamps and the fog lamps below them are one light where both clip: taller than wide, by more
// than a lamp that comes at `kFastest_mps` is drawn out within the exposure, and with more that
// clips than one round lamp of that width has, for an image on a wet road adds little to that.
bool holds_one_below(const Blob& blob, const RoadView& view) {
  constexpr double kLeastTaller_px = 2.0, kTallerShare = 0.25, kFastest_mps = 40.0;
  constexpr double kRound = 0.25 * kPi;
  if (blob.kind != LampKind::headlamp || has(blob.defects, Defect::cut_by_edge)) return false;
  const double width = width_px(blob.box), taller_px = height_px(blob.box) - width;
  if (taller_px < std::max(kLeastTaller_px, kTallerShare * width) ||
      blob.saturated_px < kRound * width * width)
    return false;
  const auto at_px = view.spot_from_pixel(blob.centre_px);
  if (!at_px) return false;
  const LampPlace at = view.place(*at_px);
  return taller_px > kLeastTaller_px + view.exposure_s() * kFastest_mps * at.inverse_depth_per_m *
                                           std::abs(at.toward_px.y());
}

Spot spot_of(const Blob& blob, const Eigen::Vector2d& centre_px, const Eigen::Vector2d& at_px) {
  constexpr double kFloor_px = 0.3, kShareOfSize = 0.06;
  Spot spot;
  spot.blob = &blob;
  spot.at_px = at_px;
  spot.centre_px = centre_px;
  spot.centre_sigma_px = blob.centre_sigma_px;
  const double size_px = std::max(width_px(blob.box), height_px(blob.box));
  spot.sigma_px = std::hypot(blob.centre_sigma_px.maxCoeff(), kFloor_px + kShareOfSize * size_px);
  return spot;
}

}  // namespace

std::vector<Spot> spots_of(const BlobFrame& frame, const RoadView& view) {
  constexpr double kTopShare = 0.25;  // of the width, how well the top tells where the lamp is
  constexpr double kSideShare = 0.1;  // the lower of two lamps need not be right below
  std::vector<Spot> spots;
  for (const Blob& blob : frame.blobs) {
    Eigen::Vector2d centre_px = blob.centre_px;
    const bool drawn_out = is_drawn_out(blob);
    const bool streak =
        drawn_out && std::any_of(frame.blobs.begin(), frame.blobs.end(),
                                 [&](const Blob& lamp) { return shines_above(lamp, blob, view); });
    const bool with_streak = drawn_out && !streak && blob.kind != LampKind::other;
    const bool holds_two = !drawn_out && holds_one_below(blob, view);
    if (with_streak || holds_two) centre_px.y() = blob.box.v_min + 0.5 * (width_px(blob.box) - 1.0);
    const auto at_px = view.spot_from_pixel(centre_px);
    if (!at_px) continue;
    Spot& spot = spots.emplace_back(spot_of(blob, centre_px, *at_px));
    spot.streak = streak;
    spot.with_streak = with_streak;
    const auto holds = [&](const Blob& light) { return hangs_below(light, blob); };
    const bool touches = spot.with_streak || std::ranges::any_of(frame.blobs, holds);
    if (touches || holds_two)
      spot.centre_sigma_px.y() =
          std::hypot(spot.centre_sigma_px.y(), kTopShare * width_px(blob.box));
    if (holds_two)
      spot.centre_sigma_px.x() =
          std::hypot(spot.centre_sigma_px.x(), kSideShare * width_px(blob.box));
    spot.casts_image =
        !streak && (touches || std::ranges::any_of(frame.blobs, [&](const Blob& light) {
                      return is_drawn_out(light) && shines_above(blob, light, view);
                    }));
  }
  return spots;
}

}  // namespace vildar
