#include "estimate/one_place.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <string>
#include <utility>

#include "core/by_frame.h"
#include "core/median.h"
#include "estimate/drawn.h"
#include "estimate/goes_on.h"
#include "estimate/line_fit.h"
#include "estimate/mixture.h"
#include "estimate/offset.h"
#include "estimate/side_light.h"

namespace vildar {
namespace {

constexpr double kLongestGap_s = 3.5;

bool shows_pair(const VehicleSighting& sighting) { return sighting.left && sighting.right; }

// The frames that show both: `look(row of one, row of other)`.
template <class Look>
void look_at_both(const VehicleEstimate& one, const VehicleEstimate& other, Look look) {
  for_each_common_frame(
      one.rows, other.rows, [](const TrackRow& row) { return row.sighting.frame; }, look);
}

// Two vehicles show four lamps, apart from when one hides the other.
bool often_show_four_lamps(const VehicleEstimate& one, const VehicleEstimate& other) {
  constexpr double kSeldom = 0.25;
  int together = 0, four = 0;
  look_at_both(one, other, [&](const TrackRow& a, const TrackRow& b) {
    ++together;
    four += shows_pair(a.sighting) && shows_pair(b.sighting);
  });
  return four > kSeldom * together;
}

bool always_alone(const VehicleEstimate& one) {
  return std::ranges::none_of(one.rows,
                              [](const TrackRow& row) { return shows_pair(row.sighting); });
}

// Whether `one` says less about the vehicle than `other` does.
bool says_less(const VehicleEstimate& one, const VehicleEstimate& other) {
  const SpeedEstimate &a = one.result.speed, &b = other.result.speed;
  return a.std_mps * b.speed_mps > b.std_mps * a.speed_mps;
}

std::optional<double> width_rad(const TrackRow& row) {
  if (!row.bearing_left_rad || !row.bearing_right_rad) return std::nullopt;
  return (*row.bearing_left_rad - *row.bearing_right_rad).norm();
}

// Whether the lamps of two pairs stand right below one another: fog lamps or daytime strips, and
// headlamps. A follower's are hidden by the roof of the one ahead or 0.8 m higher in the picture.
bool share_a_front(const VehicleEstimate& one, const VehicleEstimate& other) {
  constexpr double kAside_m = 0.35, kUpright_m = 0.6, kMostly = 0.8, kMostWider = 1.6;
  constexpr int kFewest = 5;
  int pairs = 0, below = 0;
  look_at_both(one, other, [&](const TrackRow& a, const TrackRow& b) {
    const auto range_m = a.range_m ? a.range_m : b.range_m;
    if (!shows_pair(a.sighting) || !shows_pair(b.sighting) || !range_m || !a.bearing_left_rad ||
        !a.bearing_right_rad || !b.bearing_left_rad || !b.bearing_right_rad)
      return;
    const auto close = [&](const Eigen::Vector2d& lamp_rad, const Eigen::Vector2d& other_rad) {
      const Eigen::Vector2d off_m = *range_m * (lamp_rad - other_rad).cwiseAbs();
      return off_m.x() < kAside_m && off_m.y() < kUpright_m;
    };
    const double wider = *width_rad(a) / *width_rad(b);
    ++pairs;
    below += wider < kMostWider && wider > 1.0 / kMostWider &&
             close(*a.bearing_left_rad, *b.bearing_left_rad) &&
             close(*a.bearing_right_rad, *b.bearing_right_rad);
  });
  return pairs >= kFewest && below > kMostly * pairs;
}

double brightest_flux(const TrackRow& row) {
  double flux = 0.0;
  for (const auto& lamp : {row.sighting.left, row.sighting.right})
    if (lamp) flux = std::max(flux, lamp->flux);
  return flux;
}

double brighter(const TrackRow& one, const TrackRow& other) {
  constexpr double kLeastFlux = 1e-9;
  return std::max(brightest_flux(one), kLeastFlux) / std::max(brightest_flux(other), kLeastFlux);
}

// Whether a lamp of `one`, which clips, is drawn out beside those of `other`: taller for its width,
// and with less light for its size, as an image on a rough wet road is.
bool drawn_out(const TrackRow& one, const TrackRow& other) {
  constexpr double kTaller = 1.2, kLeastTall_px = 10.0;
  struct Shape {
    double flux = 0.0, flux_per_px = 0.0, slenderness = 0.0, height_px = 0.0;
    bool clips = false;
  };
  const auto shape_of = [](const TrackRow& row) {
    Shape brightest;
    for (const auto& lamp : {row.sighting.left, row.sighting.right}) {
      if (!lamp || lamp->flux <= brightest.flux) continue;
      const double width_px = lamp->box.u_max - lamp->box.u_min + 1.0;
      const double height_px = lamp->box.v_max - lamp->box.v_min + 1.0;
      brightest = {lamp->flux, lamp->flux / (width_px * height_px), height_px / width_px, height_px,
                   lamp->saturated_px > 0};
    }
    return brightest;
  };
  const Shape a = shape_of(one), b = shape_of(other);
  return a.clips && a.height_px >= kLeastTall_px && a.slenderness > kTaller * b.slenderness &&
         a.flux_per_px < b.flux_per_px;
}

// Of two pairs that share a front: whether those of `one` are not its headlamps. These outshine fog
// lamps below them and strips about them by far; where they do not, they are the upper ones.
bool not_the_headlamps(const VehicleEstimate& one, const VehicleEstimate& other) {
  constexpr double kOutshines = 2.0;
  std::vector<double> strengths, above_rad;
  look_at_both(one, other, [&](const TrackRow& a, const TrackRow& b) {
    if (!shows_pair(a.sighting) || !shows_pair(b.sighting) || !a.bearing_rad || !b.bearing_rad)
      return;
    strengths.push_back(brighter(a, b));
    above_rad.push_back(a.bearing_rad->y() - b.bearing_rad->y());
  });
  const double strength = median(strengths);
  if (strength > kOutshines || strength < 1.0 / kOutshines) return strength < 1.0;
  return median(above_rad) < 0.0;
}

// Of the frames that show both: how far `carrier` is, and how far `upper` seems to be by its
// elevation, as if its lamps were as high as the carrier's. `in_line` is the share in which they
// stand one above the other.
struct Together {
  std::vector<double> carrier_m, upper_m;
  std::vector<double> brighter;  // the upper lamps over the carrier's
  std::vector<double> width;     // of the upper pair over the carrier's, where both show one
  double drawn_out = 0.0;        // share in which the carrier's are, beside the upper
  double in_line = 0.0;
  double mean_off_m = 0.0;  // across, where the carrier is
};

// Of the pair's middle, or of the one lamp that is seen: they stand level.
std::optional<Eigen::Vector2d> bearing_rad(const TrackRow& row) {
  if (row.bearing_rad) return row.bearing_rad;
  return row.bearing_left_rad ? row.bearing_left_rad : row.bearing_right_rad;
}

Together seen_together(const VehicleEstimate& upper, const VehicleEstimate& carrier) {
  constexpr double kLeastDown_rad = 1e-3;
  // One lamp may be at the side of a lorry, and the other one at its other side.
  constexpr double kPair_m = 1.2, kAlone_m = 1.5, kBothAlone_m = 2.6;
  const double alone_m = always_alone(carrier) ? kBothAlone_m : kAlone_m;
  const double beside_m = always_alone(upper) ? alone_m : kPair_m;
  Together seen;
  // Where it stands, or is not measured, the carrier is about where it next is.
  std::vector<double> before_rad;
  double in_line = 0.0, looks = 0.0;
  look_at_both(upper, carrier, [&](const TrackRow& a, const TrackRow& b) {
    const auto above_rad = bearing_rad(a), carrier_rad = b.bearing_rad;
    if (!above_rad || !carrier_rad) return;
    before_rad.push_back(above_rad->x() - carrier_rad->x());
    if (!b.range_m) return;
    for (const double off_rad : before_rad) in_line += std::abs(*b.range_m * off_rad) < beside_m;
    looks += static_cast<double>(before_rad.size());
    before_rad.clear();
    const double upper_down = -above_rad->y(), carrier_down = -carrier_rad->y();
    if (upper_down < kLeastDown_rad || carrier_down < kLeastDown_rad) return;
    const double off_rad = above_rad->x() - carrier_rad->x();
    seen.mean_off_m += *b.range_m * off_rad;
    seen.brighter.push_back(brighter(a, b));
    if (const auto upper_rad = width_rad(a), under_rad = width_rad(b); upper_rad && under_rad)
      seen.width.push_back(*upper_rad / *under_rad);
    seen.drawn_out += drawn_out(b, a);
    seen.carrier_m.push_back(*b.range_m);
    seen.upper_m.push_back(*b.range_m * std::tan(carrier_down) / std::tan(upper_down));
  });
  const auto count = static_cast<double>(std::max<std::size_t>(1, seen.carrier_m.size()));
  seen.in_line = in_line / std::max(1.0, looks);
  seen.mean_off_m /= count;
  seen.drawn_out /= count;
  return seen;
}

// How the lamps of `upper` keep in one line with the camera and those of `carrier`, from high over
// the lamps: as if they were farther off by a factor, and as much faster.
struct InLine {
  double factor = 1.0;
  double back_m = 0.0;      // of the upper lamps' place behind the carrier's
  double over_m = 0.0;      // over the carrier's, if those are where they seem to be
  double mean_off_m = 0.0;  // across
  double brighter = 0.0;    // the upper lamps over the carrier's
  double width = 1.0;       // of the upper pair where it seems to be, over the carrier's
  bool drawn_out = false;   // the carrier's lamps, in a third of the frames or more
  double nearer = 1.0;      // by which factor the carrier comes nearer, or goes away
};

std::optional<InLine> keeps_in_line(const VehicleEstimate& upper, const VehicleEstimate& carrier,
                                    double over_lamps_m) {
  constexpr double kHighCamera_m = 2.0, kNearer = 1.1, kShareInLine = 0.8, kSigmas = 3.0;
  constexpr double kMostBack_m = 5.0, kMostBackSigma_m = 2.0, kDrawnOut = 1.0 / 3.0;
  constexpr std::size_t kFewest = 10;
  if (over_lamps_m < kHighCamera_m || upper.trajectories.empty() || carrier.trajectories.empty() ||
      upper.result.direction != carrier.result.direction)
    return std::nullopt;
  const Together seen = seen_together(upper, carrier);
  const std::size_t frames = seen.carrier_m.size();
  if (frames < kFewest || seen.in_line < kShareInLine) return std::nullopt;
  const auto [nearest_m, farthest_m] = std::ranges::minmax(seen.carrier_m);
  if (farthest_m < kNearer * nearest_m) return std::nullopt;
  // The factor is the line's slope, the place behind the carrier's lamps its intercept.
  const auto line = fit_line(seen.carrier_m, seen.upper_m);
  const auto* fit = std::get_if<LineFit>(&line);
  if (!fit || fit->slope - 1.0 < kSigmas * fit->slope_sigma) return std::nullopt;
  const double mean_m = std::accumulate(seen.carrier_m.begin(), seen.carrier_m.end(), 0.0) /
                        static_cast<double>(frames);
  const double back_sigma_m =
      std::hypot(fit->residual_sigma / std::sqrt(static_cast<double>(frames)),
                 fit->slope_sigma * mean_m) /
      fit->slope;
  InLine found{.factor = fit->slope,
               .back_m = fit->intercept / fit->slope,
               .over_m = over_lamps_m * (1.0 - 1.0 / fit->slope),
               .mean_off_m = seen.mean_off_m,
               .brighter = median(seen.brighter),
               .drawn_out = seen.drawn_out > kDrawnOut,
               .nearer = farthest_m / nearest_m};
  if (!seen.width.empty()) found.width = found.factor * median(seen.width);
  if (std::abs(found.back_m) > kMostBack_m || back_sigma_m > kMostBackSigma_m) return std::nullopt;
  return found;
}

std::string named(const VehicleEstimate& vehicle) {
  return "vehicle " + std::to_string(vehicle.result.track_id);
}

void withhold_second(VehicleEstimate& second, const std::string& why) {
  withhold(second, Miss::ambiguous_identity, {Method::geometry_camera, Method::fused}, why);
}

}  // namespace

bool one_vehicle(const VehicleEstimate& one, const VehicleEstimate& other) {
  // Nearer to one another no vehicles follow, or drive in two lanes.
  constexpr double kMostOff_m = 5.0, kMostBeside_m = 1.2;
  constexpr double kSigmas = 3.0, kSigmasAlone = 2.0;
  constexpr int kSteps = 8;
  const VehicleResult &a = one.result, &b = other.result;
  if (one.trajectories.empty() || other.trajectories.empty() || a.direction != b.direction)
    return false;
  const double from_s = std::max(a.t_first_s, b.t_first_s);
  const double to_s = std::min(a.t_last_s, b.t_last_s);
  if (from_s - to_s > kLongestGap_s) return false;
  if (share_a_front(one, other)) return true;
  // Four lamps are of one only where two bodies would surely be in one another: a camera that
  // smooths over time shows what it saw a frame before as well.
  constexpr double kInside_m = 3.0, kSurely = 2.0;
  const bool four = often_show_four_lamps(one, other);
  const bool in_turn = from_s > to_s;
  const bool alone = always_alone(one) != always_alone(other);

  Offset surest{0.0, 0.0, INFINITY};
  for (int i = 0; i <= kSteps; ++i) {
    const double time_s = from_s + (to_s - from_s) * i / kSteps;
    Offset offset = offset_at(one, other, time_s);
    if (in_turn) {  // it may have braked or sped up while neither was in view
      constexpr double kAcceleration_mps2 = 1.0;
      const double before_s = from_s - time_s, after_s = time_s - to_s;
      offset.sigma_m = std::hypot(offset.sigma_m, 0.5 * kAcceleration_mps2 * before_s * before_s,
                                  0.5 * kAcceleration_mps2 * after_s * after_s);
    }
    if (std::abs(offset.along_m) > kSigmas * offset.sigma_m ||
        (four && std::abs(offset.along_m) + kSurely * offset.sigma_m > kInside_m))
      return false;
    if (offset.sigma_m < surest.sigma_m) surest = offset;
  }
  if (in_turn && 2.0 * surest.sigma_m > kMostOff_m) return false;
  const double most_off_m =
      alone ? std::max(kMostOff_m, kSigmasAlone * surest.sigma_m) : kMostOff_m;
  return std::abs(surest.along_m) < most_off_m && std::abs(surest.beside_m) < kMostBeside_m;
}

bool rides_on(const VehicleEstimate& upper, const VehicleEstimate& carrier, double over_lamps_m) {
  constexpr double kLowest_m = 0.6, kHighest_m = 3.6;  // of the lamps over headlamps
  constexpr double kLeastBack_m = -3.0, kMostBack_m = 3.5;
  constexpr double kAbove_m = 0.35, kBody_m = 1.8, kSurelyFaster = 1.4, kFaster = 1.5,
                   kFastest_mps = 60.0, kNarrow = 0.6, kFaint = 0.5, kNearer = 1.2;
  const auto line = keeps_in_line(upper, carrier, over_lamps_m);
  if (!line) return false;
  // A faster vehicle in the next lane that passes the camera at once with the other is in line with
  // it, too; not right above it, nor so much faster. In one lane the two would run into each other;
  // that a follower's pair comes up to the one ahead, though, its lengths may make it seem.
  const double time_s = upper.result.speed.time_s;
  const double beside_m = mixed_state(upper.trajectories, time_s).lateral_m -
                          mixed_state(carrier.trajectories, time_s).lateral_m;
  const bool alone = always_alone(upper);
  const bool collides = std::abs(beside_m) < kBody_m && (line->factor > kSurelyFaster || alone);
  // In line with a pair, one light or a narrow pair is as likely an end of the lamps over a lorry's
  // cab as a motorcycle that passes the camera at once with it; lamps fainter than the pair's,
  // if they were where they seem to be, are likelier markers than headlamps.
  const bool over_pair = !always_alone(carrier);
  const bool end_of_row = over_pair && (alone || line->width < kNarrow);
  const bool faint = over_pair && line->brighter * line->factor * line->factor < kFaint;
  const bool drives_so = !upper.result.lane.empty() && std::abs(line->mean_off_m) > kAbove_m &&
                         !collides && !end_of_row && !faint && line->factor < kFaster &&
                         upper.result.speed.speed_mps < kFastest_mps;
  return !drives_so && (faint || line->nearer > kNearer) && line->over_m > kLowest_m &&
         line->over_m < kHighest_m && line->back_m > kLeastBack_m && line->back_m < kMostBack_m;
}

bool mirrors(const VehicleEstimate& lower, const VehicleEstimate& source, double over_lamps_m,
             double lamp_height_m) {
  constexpr double kLeast_m = 0.3, kSlack = 1.15, kAside_m = 0.35, kNearer = 1.3;
  constexpr double kMostBack_m = 2.0, kDrawnOutBack_m = 3.5;
  const auto line = keeps_in_line(source, lower, over_lamps_m);
  if (!line) return false;
  // The image of a smooth road stands as far below the road as the lamp above it; a rough road
  // draws it out upward.
  const double image_m = 2.0 * lamp_height_m * over_lamps_m / (over_lamps_m + 2.0 * lamp_height_m);
  // A beam that shines down on a wet road and not up to a mast has an image brighter than its lamp:
  // it is right where that stands, and as wide. So high over a car's headlamps is no roof.
  constexpr double kOfImage = 0.25, kOfWidth = 0.05, kRightBelow_m = 0.5;
  const bool right_below = std::abs(line->over_m - image_m) < kOfImage * image_m &&
                           std::abs(line->width / line->factor - 1.0) < kOfWidth &&
                           std::abs(line->back_m) < kRightBelow_m;
  if (line->nearer < kNearer && !right_below) return false;
  // A streak of light that clips has more of it than the lamp, over more pixels, and its middle is
  // anywhere along it.
  const double most_back_m = line->drawn_out ? kDrawnOutBack_m : kMostBack_m;
  if (!(line->brighter > 1.0 || line->drawn_out || right_below) ||
      std::abs(line->mean_off_m) > kAside_m || std::abs(line->back_m) > most_back_m)
    return false;
  return line->over_m > kLeast_m && line->over_m < kSlack * image_m;
}

bool on_the_body(const VehicleEstimate& light, const VehicleEstimate& carrier) {
  constexpr double kGap_s = 0.25, kShortest_m = 3.5;  // gap to the next vehicle, and a car
  constexpr double kBefore_m = 1.0, kMostBeside_m = 1.3, kLeast_s = 1.0;
  // Further back a strong light by the middle is another vehicle's.
  constexpr double kCar_m = 4.5, kSide_m = 0.6, kFaint = 0.6;
  // Two lights are the front of what it draws, at a drawbar's length, in line and faint.
  constexpr double kDrawn_m = 8.0, kRigid_m = 0.5;
  constexpr int kSteps = 8;
  const VehicleResult &a = light.result, &b = carrier.result;
  const double from_s = std::max(a.t_first_s, b.t_first_s);
  const double to_s = std::min(a.t_last_s, b.t_last_s);
  if (light.trajectories.empty() || carrier.trajectories.empty() || a.direction != b.direction ||
      always_alone(carrier) || to_s - from_s < kLeast_s)
    return false;
  const bool alone = always_alone(light);
  double least_behind_m = INFINITY, most_behind_m = -INFINITY;
  double surest_m = INFINITY, surest_behind_m = 0.0, surest_beside_m = 0.0;
  bool on_it = false;
  for (int i = 0; i <= kSteps; ++i) {
    const double time_s = from_s + (to_s - from_s) * i / kSteps;
    const MotionState one = mixed_state(light.trajectories, time_s);
    const MotionState other = mixed_state(carrier.trajectories, time_s);
    const double behind_m = one.range_m - other.range_m;
    const double sigma_m = std::hypot(one.range_std_m, other.range_std_m);
    const double follower_m = kShortest_m + kGap_s * std::abs(other.over_ground_mps);
    const double most_m = alone ? follower_m : std::min(kDrawn_m, follower_m);
    least_behind_m = std::min(least_behind_m, behind_m);
    most_behind_m = std::max(most_behind_m, behind_m);
    if (behind_m < -kBefore_m - sigma_m || behind_m > most_m + sigma_m) return false;
    if (sigma_m > surest_m) continue;
    surest_m = sigma_m;
    surest_behind_m = behind_m;
    surest_beside_m = std::abs(one.lateral_m - other.lateral_m);
    on_it = behind_m - sigma_m > -kBefore_m && behind_m + sigma_m < most_m &&
            surest_beside_m < kMostBeside_m;
  }
  if (!alone) on_it &= most_behind_m - least_behind_m < kRigid_m && surest_beside_m < kSide_m;
  if (!on_it || (alone && (surest_behind_m < kCar_m || surest_beside_m > kSide_m))) return on_it;
  std::vector<double> strengths;
  look_at_both(light, carrier, [&](const TrackRow& one, const TrackRow& other) {
    if (one.range_m && other.range_m)
      strengths.push_back(brighter(one, other) * std::pow(*one.range_m / *other.range_m, 2));
  });
  return !strengths.empty() && median(strengths) < kFaint;
}

bool glints_beside(const VehicleEstimate& light, const VehicleEstimate& source) {
  constexpr std::size_t kFewest = 10;
  constexpr double kNearer = 1.3, kMostOff_m = 1.0;
  constexpr double kLeastShare = 0.3, kMostShare = 0.9;  // of the source's distance
  constexpr double kFaint = 0.6;
  if (light.trajectories.empty() || source.trajectories.empty() || !always_alone(light) ||
      always_alone(source) || light.result.direction != source.result.direction)
    return false;
  std::vector<double> source_m, light_m, strengths;
  int outside = 0;
  look_at_both(light, source, [&](const TrackRow& a, const TrackRow& b) {
    const auto light_rad = bearing_rad(a), source_rad = bearing_rad(b);
    if (!light_rad || !source_rad || !a.range_m || !b.range_m) return;
    source_m.push_back(*b.range_m);
    light_m.push_back(*a.range_m);
    strengths.push_back(brighter(a, b) * std::pow(*a.range_m / *b.range_m, 2));
    outside += source_rad->x() * (light_rad->x() - source_rad->x()) > 0.0;
  });
  if (source_m.size() < kFewest || 2 * outside < static_cast<int>(source_m.size())) return false;
  const auto [nearest_m, farthest_m] = std::ranges::minmax(source_m);
  const auto line = fit_line(source_m, light_m);
  const auto* fit = std::get_if<LineFit>(&line);
  return fit && farthest_m > kNearer * nearest_m && std::abs(fit->intercept) < kMostOff_m &&
         fit->slope > kLeastShare && fit->slope < kMostShare && median(strengths) < kFaint;
}

namespace {

void withhold_side_light(VehicleEstimate& light, const VehicleEstimate& carrier) {
  if (on_the_body(light, carrier) || is_side_marker(light, carrier))
    withhold_second(
        light,
        "keeps to a place within the length of " + named(carrier) +
            (always_alone(light)
                 ? "; taken for a light on its side, though a motorcycle close to it looks the same"
                 : "; taken for the front of what that draws"));
}

}  // namespace

bool MeasuredVehicles::withhold_part(VehicleEstimate& upper, VehicleEstimate& carrier) const {
  if (mirrors(carrier, upper, over_lamps_m_, lamp_height_m_)) {
    withhold_second(carrier, "moves as the image of the lamps of " + named(upper) +
                                 " on a wet road would; taken for that");
  } else if (rides_on(upper, carrier, over_lamps_m_)) {
    withhold_second(upper, "moves as lamps on the roof of " + named(carrier) +
                               " would; taken for lamps of that vehicle");
    if (always_alone(carrier) && !always_alone(upper))
      withhold_second(carrier, "moves as what the lamps of " + named(upper) +
                                   " light would, or is the only lamp of a vehicle with those on "
                                   "its roof; which cannot be told");
  } else if (glints_beside(upper, carrier)) {
    withhold_second(upper, "moves as a glint of " + named(carrier) +
                               " on a rail beside the road would; taken for one");
  } else {
    return false;
  }
  return true;
}

void MeasuredVehicles::add(VehicleEstimate estimate) {
  for (VehicleEstimate& earlier : held_) {
    if (earlier.result.t_last_s < estimate.result.t_first_s - kLongestGap_s ||
        estimate.result.t_last_s < earlier.result.t_first_s - kLongestGap_s)
      continue;
    if (withhold_part(earlier, estimate) || withhold_part(estimate, earlier)) continue;
    const bool one = one_vehicle(earlier, estimate) || goes_on_as(earlier, estimate) ||
                     goes_on_as(estimate, earlier) || comes_out_again(earlier, estimate) ||
                     comes_out_again(estimate, earlier);
    if (!one && !one_draws_the_other(earlier, estimate)) {
      withhold_side_light(earlier, estimate);
      withhold_side_light(estimate, earlier);
      continue;
    }
    const bool earlier_goes = one && share_a_front(earlier, estimate)
                                  ? not_the_headlamps(earlier, estimate)
                                  : says_less(earlier, estimate);
    const std::string stays = named(earlier_goes ? estimate : earlier);
    withhold_second(earlier_goes ? earlier : estimate,
                    one ? "stands where " + stays + " does; taken for the same vehicle, seen twice"
                        : "keeps a place nearer to " + stays +
                              " than vehicles follow; taken for a trailer and what draws it");
  }
  held_.push_back(std::move(estimate));
}

std::vector<VehicleEstimate> MeasuredVehicles::take_before(double time_s) {
  const auto gone = std::stable_partition(
      held_.begin(), held_.end(),
      [&](const VehicleEstimate& one) { return one.result.t_last_s >= time_s - kLongestGap_s; });
  std::vector<VehicleEstimate> taken(std::make_move_iterator(gone),
                                     std::make_move_iterator(held_.end()));
  held_.erase(gone, held_.end());
  return taken;
}

}  // namespace vildar
