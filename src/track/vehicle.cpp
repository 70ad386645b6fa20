#include "track/vehicle.h"

#include <algorithm>
#include <cmath>

#include "core/median.h"
#include "optics/lamp_colour.h"
#include "track/lamp_way.h"
#include "track/lone_course.h"
#include "track/lone_light.h"
#include "track/lone_oncoming.h"
#include "track/lone_parts.h"

namespace vildar {
namespace {

// Tail lamps differ more than headlamps do: 4 to 17 cd by rule, bicycles' less.
constexpr double kFaintPair = 2.5, kFaintSingle = 1.5, kFaintSingleTail = 2.5;
constexpr double kUnderTailLamps = 1.0;
constexpr double kHiddenByClippingLn = 2.0;  // a clipped lamp is at least as bright as measured
constexpr double kLeastPairShare = 0.15, kLeastPairShareMoving = 0.3;
constexpr double kNotWhite = -1.2;      // ln of the odds of a tail lamp: warm white has -1.8
constexpr double kMostPairChi2 = 30.0;  // of one frame, about 2 degrees of freedom

LampSighting sighting_of(const LampRecord& record) {
  LampSighting sighting = record.sighting;
  // The centre is the pair's, within half the separation, or it is that of two neighbours.
  const double doubt_px = std::hypot(record.merged_px, 0.5 * record.beside_px);
  if (doubt_px > 0.0) {
    sighting.defects = sighting.defects | Defect::merged;
    sighting.centre_sigma_px.array() =
        sighting.centre_sigma_px.array().square() + doubt_px * doubt_px;
    sighting.centre_sigma_px = sighting.centre_sigma_px.cwiseSqrt();
  }
  return sighting;
}

/// A frame in which both lamps were seen apart.
struct PairLook {
  double time_s, slope_down, inverse_depth_per_m, width_per_depth;
  Eigen::Vector2d middle_px;
};

double duration_s(const std::vector<VehicleSighting>& sightings) {
  return seconds_of(sightings.back().time) - seconds_of(sightings.front().time);
}

// Least-squares slope of values over times.
double slope_of(const std::vector<double>& times, const std::vector<double>& values) {
  const double n = static_cast<double>(times.size());
  double st = 0.0, sv = 0.0, stt = 0.0, stv = 0.0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double t = times[i] - times.front();
    st += t;
    sv += values[i];
    stt += t * t;
    stv += t * values[i];
  }
  const double spread = stt - st * st / n;
  return spread > 0.0 ? (stv - st * sv / n) / spread : 0.0;
}

// By how much lamps may be under the usual strength, and headlamps under that of tail lamps.
struct Allowance {
  double usual_ln, tail_lamps_ln;
};

// Fainter than the lamps of this scene by more than beams and weather explain.
bool too_faint(const std::vector<double>& strengths, LampKind kind, const LightScale& lights,
               std::optional<double> usual, double slope_down, const Allowance& allowed) {
  const std::optional<double> tail = lights.typical(LampKind::taillamp);
  const double strength = median(strengths) + lights.dimmer_ln(slope_down, kind);
  return (usual && strength < *usual - allowed.usual_ln) ||
         (kind == LampKind::headlamp && tail && strength < *tail - allowed.tail_lamps_ln);
}

double median_slope_down(const std::vector<PairLook>& looks) {
  std::vector<double> slopes_down;
  for (const PairLook& look : looks) slopes_down.push_back(look.slope_down);
  return median(std::move(slopes_down));
}

// Whether a pair comes, or goes, plainly as lamps of a kind that drive do, and no light that
// stands. `scale_doubt`: by how much its separation may differ from what lamps have.
bool drives_as(LampKind kind, const std::vector<PairLook>& looks, double scale_doubt,
               double slow_mps, const RoadView& view) {
  constexpr double kClear_m = 4.0, kClearShare = 0.25;
  std::vector<double> times_s, ranges_m;
  for (const PairLook& look : looks) {
    times_s.push_back(look.time_s);
    ranges_m.push_back(view.separation_m() / look.width_per_depth);
  }
  const double closing_mps = -slope_of(times_s, ranges_m);
  const double nearer_m = closing_mps * (times_s.back() - times_s.front());
  const double ego_mps = view.ego_speed_mps(0.5 * (times_s.front() + times_s.back()));
  const double ego_m = ego_mps * (times_s.back() - times_s.front());
  const double clear_m = std::max(kClear_m, kClearShare * median(ranges_m));
  if (std::max(std::abs(nearer_m), ego_m) < clear_m) return false;
  if (kind == LampKind::headlamp) return closing_mps / scale_doubt - slow_mps > ego_mps;
  return closing_mps * scale_doubt + slow_mps < ego_mps;
}

// Before a camera that stands a pair comes nearer on the road as it grows; what is shown on a sign
// does not.
bool moves_as_it_grows(const std::vector<PairLook>& looks, const RoadView& view) {
  constexpr double kMost = 2.5;
  std::vector<double> times_s, by_width_ln, by_place_ln;
  for (const PairLook& look : looks) {
    times_s.push_back(look.time_s);
    by_width_ln.push_back(std::log(look.width_per_depth));
    by_place_ln.push_back(std::log(view.place(look.middle_px).inverse_depth_per_m));
  }
  const double ratio = slope_of(times_s, by_place_ln) / slope_of(times_s, by_width_ln);
  return ratio > 1.0 / kMost && ratio < kMost;
}

// The lamps' colour says which way the vehicle faces; does its range clearly say the opposite?
bool motion_contradicts(const std::vector<PairLook>& looks, LampKind kind, const RoadView& view) {
  constexpr double kScaleDoubt = 1.35, kSlow_mps = 3.0;
  const LampKind opposite = kind == LampKind::headlamp ? LampKind::taillamp : LampKind::headlamp;
  return drives_as(opposite, looks, kScaleDoubt, kSlow_mps, view);
}

constexpr double kMoved_m = 4.0;  // along the road, by less a light may seem to move that stands

// A pair that stays where it was found, before a camera that stands: letters burnt into the
// picture, a lit sign, a parked car.
bool stays(const std::vector<PairLook>& looks, const RoadView& view) {
  std::vector<double> times_s, ranges_m, u_px, v_px;
  for (const PairLook& look : looks) {
    times_s.push_back(look.time_s);
    ranges_m.push_back(1.0 / view.place(look.middle_px).inverse_depth_per_m);
    u_px.push_back(look.middle_px.x());
    v_px.push_back(look.middle_px.y());
  }
  const double duration_s = times_s.back() - times_s.front();
  return std::abs(slope_of(times_s, ranges_m)) * duration_s < kMoved_m &&
         std::hypot(slope_of(times_s, u_px), slope_of(times_s, v_px)) * duration_s < kMoved_px;
}

bool beside_the_road(const std::vector<double>& laterals_m,
                     const std::vector<double>& lateral_sigmas_m, const RoadView& view) {
  constexpr double kMargin_m = 2.0, kMarginShare = 0.25, kSigmas = 2.5;
  const double lateral_m = median(laterals_m);
  const double margin_m = std::hypot(kMargin_m + kMarginShare * std::abs(lateral_m),
                                     kSigmas * median(lateral_sigmas_m));
  return view.beyond_lanes_m(lateral_m) > margin_m;
}

}  // namespace

std::vector<LampRecord> records_of(const Vehicle& vehicle, const Lamp* lamp,
                                   const std::vector<LampRecord>& past) {
  std::vector<LampRecord> records;
  const auto append = [&](const std::vector<LampRecord>& more) {
    for (const LampRecord& record : more)
      if ((records.empty() || record.frame > records.back().frame) &&
          !(vehicle.cut_after && record.frame > *vehicle.cut_after))
        records.push_back(record);
  };
  append(past);
  if (lamp) append(lamp->records);
  return records;
}

CameraTime last_seen(const Vehicle& lost) {
  CameraTime last;
  for (const auto* past : {&lost.past_left, &lost.past_right})
    if (!past->empty()) last = std::max(last, past->back().time);
  return last;
}

double strength_of(const Lamp& lamp) {
  const Vehicle* vehicle = lamp.vehicle;
  const double inverse_depth = vehicle && vehicle->left && vehicle->right
                                   ? vehicle->inverse_depth_per_m
                                   : lamp.place().inverse_depth_per_m;
  return lamp.log_flux() - 2.0 * std::log(inverse_depth);
}

bool outshines(const Lamp& left, const Lamp& right, const Vehicle& other, bool known_first) {
  constexpr double kEqualLn = 0.5, kFarBelowLn = 1.5, kFogLampsBelow_m = 0.7, kLevel_m = 0.15;
  const double more_ln = std::min(left.log_flux(), right.log_flux()) -
                         std::min(other.left->log_flux(), other.right->log_flux());
  const Eigen::Vector2d apart_px =
      0.5 * (left.at_px() + right.at_px() - other.left->at_px() - other.right->at_px());
  const Eigen::Vector2d& down_px = left.place().down_px;
  const double lower_m =
      apart_px.dot(down_px) / (down_px.squaredNorm() * other.inverse_depth_per_m);
  if (std::abs(lower_m) < kLevel_m)
    return std::abs(more_ln) > kEqualLn ? more_ln > 0.0 : known_first;
  if (std::abs(lower_m) < kFogLampsBelow_m && std::abs(more_ln) < kFarBelowLn) return lower_m < 0.0;
  if (std::abs(more_ln) > kEqualLn) return more_ln > 0.0;
  return lower_m > 0.0;
}

void cut_where_it_came_apart(Vehicle& gone) {
  if (gone.cut_after || gone.chi2 <= kMostMeanChi2 || gone.last_good == gone.last_both) return;
  gone.cut_after = gone.last_good;
  gone.came_apart = true;
}

Verdict judge_vehicle(const Vehicle& vehicle, const RoadView& view, const TrackOptions& options,
                      const LightScale& lights, VehicleTrack& track) {
  std::vector<LampRecord> left = records_of(vehicle, vehicle.left, vehicle.past_left);
  std::vector<LampRecord> right = records_of(vehicle, vehicle.right, vehicle.past_right);
  for (auto* records : {&left, &right})
    std::erase_if(*records, [&](const LampRecord& record) {
      return vehicle.last_as_another && record.frame <= *vehicle.last_as_another;
    });
  const bool one_pair = keep_longest_pair(left, right);
  int fitting = 0;
  std::vector<PairLook> looks;
  std::vector<double> laterals_m, lateral_sigmas_m, strengths, faint_log_odds;
  std::vector<double> left_tail_log_odds, right_tail_log_odds;
  int clipped = 0, patches = 0, streaks = 0;
  // Flat red ones are bars of LEDs, which run into the lamps at their ends.
  const auto is_bar = [](const LampRecord& record) {
    constexpr double kFlat = 0.2;
    const PixelBox& box = record.sighting.box;
    return record.tail_log_odds > kSurelyRed &&
           box.v_max - box.v_min + 1.0 < kFlat * (box.u_max - box.u_min + 1.0);
  };
  const auto is_patch = [&](const LampRecord& record, double inverse_depth_per_m) {
    return record.sighting.saturated_px == 0 && !is_bar(record) &&
           wider_than_a_lamp(record, inverse_depth_per_m, view);
  };
  const auto add_look = [&](const LampRecord& left_one, const LampRecord& right_one,
                            const PairFit& fit) {
    const Eigen::Vector2d middle_px = 0.5 * (left_one.at_px + right_one.at_px);
    looks.push_back({seconds_of(left_one.time), view.place(middle_px).slope_down,
                     fit.inverse_depth_per_m, fit.width_per_depth, middle_px});
    laterals_m.push_back(view.road_at(middle_px, fit.inverse_depth_per_m).lateral_m);
    lateral_sigmas_m.push_back(view.lateral_sigma_m(fit.inverse_depth_per_m));
    clipped += left_one.sighting.saturated_px > 0 && right_one.sighting.saturated_px > 0;
    streaks += left_one.streak + right_one.streak;
    patches +=
        is_patch(left_one, fit.inverse_depth_per_m) || is_patch(right_one, fit.inverse_depth_per_m);
    left_tail_log_odds.push_back(left_one.tail_log_odds);
    right_tail_log_odds.push_back(right_one.tail_log_odds);
    faint_log_odds.push_back(0.5 * (left_one.faint_tail_log_odds + right_one.faint_tail_log_odds));
    const double flux = std::min(left_one.sighting.flux, right_one.sighting.flux);
    strengths.push_back(std::log(std::max(flux, 1e-9)) - 2.0 * std::log(fit.inverse_depth_per_m));
  };
  std::vector<SeenVehicle> seen;
  for (std::size_t i = 0, j = 0; i < left.size() || j < right.size();) {
    const bool use_left = j == right.size() || (i < left.size() && left[i].frame <= right[j].frame);
    const bool use_right =
        i == left.size() || (j < right.size() && right[j].frame <= left[i].frame);
    const LampRecord& first = use_left ? left[i] : right[j];
    VehicleSighting sighting{first.frame, first.time, std::nullopt, std::nullopt};
    sighting.both_in_one = first.merged_px > 0.0;
    if (sighting.both_in_one) {
      sighting.left = sighting_of(first);
    } else {
      if (use_left) sighting.left = sighting_of(left[i]);
      if (use_right) sighting.right = sighting_of(right[j]);
    }
    bool fits = true;
    if (sighting.left && sighting.right) {
      const PairFit fit = view.fit_pair(left[i].at_px, right[j].at_px, 1.0);
      fits = fit.chi2 < kMostPairChi2;
      fitting += fits;
      if (std::isfinite(fit.chi2)) add_look(left[i], right[j], fit);  // else one above the other
    }
    seen.push_back({sighting, fits});
    i += use_left;
    j += use_right;
  }

  const double pair_share = view.moving_sensor() ? kLeastPairShareMoving : kLeastPairShare;
  drop_beside_the_way(seen, view);
  drop_strange_parts(seen, pair_share);
  track.sightings.clear();
  for (const SeenVehicle& one : seen) track.sightings.push_back(one.sighting);

  // A camera that moves sees everything move: it takes longer to know a vehicle.
  constexpr int kFewestPairs = 3, kFewestPairsMoving = 5;
  const int pairs_needed =
      std::max(view.moving_sensor() ? kFewestPairsMoving : kFewestPairs, options.min_sightings - 1);
  // Lamps that came apart may never have belonged together: it takes a long good part to tell.
  constexpr int kFewestPairsOfCut = 20, kSurePairsOfCut = 50;
  if (vehicle.came_apart && fitting < kFewestPairsOfCut) return Verdict::undecided;
  if (track.sightings.empty() || static_cast<int>(track.sightings.size()) < options.min_sightings ||
      duration_s(track.sightings) < options.min_duration_s ||
      static_cast<int>(looks.size()) < pairs_needed)
    return Verdict::short_track;
  constexpr double kSecondShare = 0.4, kImageShare = 0.5, kPatchShare = 0.5;
  if (vehicle.second_on_body > kSecondShare * vehicle.both_seen ||
      vehicle.images > kImageShare * vehicle.looks ||
      0.5 * streaks > kImageShare * static_cast<double>(looks.size()) ||
      patches > kPatchShare * static_cast<double>(looks.size()))
    return Verdict::reflection;
  const double hidden_ln = kHiddenByClippingLn * clipped / static_cast<double>(looks.size());
  // Without colour what drives away has tail lamps.
  const bool drives_away = lights.colourless() && motion_contradicts(looks, vehicle.kind, view);
  const LampKind like = drives_away ? LampKind::taillamp : vehicle.kind;
  if ((!vehicle.cut_after && vehicle.chi2 > kMostMeanChi2) ||
      too_faint(strengths, like, lights, lights.typical(like), median_slope_down(looks),
                {kFaintPair + hidden_ln, kUnderTailLamps + hidden_ln}) ||
      static_cast<double>(looks.size()) < pair_share * static_cast<double>(track.sightings.size()))
    return Verdict::undecided;
  if (!view.moving_sensor() && stays(looks, view)) return Verdict::static_light;
  track.beside_lanes_m.reset();
  if (beside_the_road(laterals_m, lateral_sigmas_m, view)) {
    // Lights along the road that stand are beside it as well.
    constexpr double kScaleDoubt = 1.2, kSlow_mps = 2.0;
    const auto drives = [&](LampKind kind) {
      return drives_as(kind, looks, kScaleDoubt, kSlow_mps, view);
    };
    const bool either_way = drives(LampKind::headlamp) || drives(LampKind::taillamp);
    if (view.moving_sensor() ? !drives(like) : !either_way || !moves_as_it_grows(looks, view))
      return Verdict::off_road;
    track.beside_lanes_m = median(laterals_m);
  }

  constexpr double kRowShare = 0.4;
  track.lights_between = vehicle.in_row > kRowShare * vehicle.both_seen;
  track.kind = vehicle.kind;
  track.direction_contradicts = motion_contradicts(looks, vehicle.kind, view);
  // Before a camera that stands the motion alone tells where nothing shows colour, and of lamps of
  // which none is white for sure: clipping whitens tail lamps, indicators are amber. From one that
  // moves, those of a vehicle ahead still do not come nearer.
  if (track.direction_contradicts) {
    constexpr double kWhitened = -2.0;
    const double whiter = std::min(median(left_tail_log_odds), median(right_tail_log_odds));
    const bool white = whiter < kWhitened && !lights.colourless();
    if (view.moving_sensor() && (vehicle.kind != LampKind::headlamp || white))
      return Verdict::undecided;
    if (view.moving_sensor() || median(faint_log_odds) > kNotWhite || lights.colourless()) {
      track.kind = LampKind::taillamp;
      track.direction_contradicts = motion_contradicts(looks, track.kind, view);
    }
  }
  track.direction = track.kind == LampKind::headlamp ? Direction::oncoming : Direction::receding;
  track.single_lamp = false;
  track.lamps_go_on = vehicle.lamps_go_on;
  track.ambiguous_identity =
      vehicle.ambiguous || !one_pair || (vehicle.came_apart && fitting < kSurePairsOfCut);
  return Verdict::vehicle;
}

bool moves_plainly(const Lamp& light, const RoadView& view) {
  constexpr double kLong_s = 1.0, kFar_rad = 0.05;
  return !view.moving_sensor() && !light.fixed && light.lived_s() >= kLong_s &&
         light.wandered_px() >= kFar_rad * view.focal_px();
}

// Which are lower than the camera by more than its pose leaves open.
std::vector<bool> below_the_camera(std::span<const LampRecord> records, const RoadView& view) {
  constexpr double kBelowSigmas = 2.0;
  std::vector<bool> below;
  for (const LampRecord& record : records) {
    const LampPlace place = view.place(record.at_px);
    below.push_back(place.slope_down > kBelowSigmas * view.slope_sigma(place.inverse_depth_per_m));
  }
  return below;
}

// For half of the time, or for long enough.
bool tells_by_elevation(std::span<const LampRecord> records, const std::vector<bool>& below) {
  constexpr std::size_t kEnough = 15;
  constexpr double kEnough_s = 0.6;
  std::vector<double> times_s;
  for (std::size_t k = 0; k < records.size(); ++k)
    if (below[k]) times_s.push_back(seconds_of(records[k].time));
  return 2 * times_s.size() >= records.size() ||
         (times_s.size() >= kEnough && times_s.back() - times_s.front() >= kEnough_s);
}

Verdict judge_single(const Lamp& lamp, const RoadView& view, const TrackOptions& options,
                     const LightScale& lights, VehicleTrack& track) {
  constexpr double kShare = 0.5, kSlow_mps = 3.0;
  constexpr int kFewestSingle = 8;
  constexpr double kSureLogOdds = 1.1;  // 3 to 1
  constexpr double kSpeedSigmas = 2.5;
  if (lamp.sightings() < options.min_sightings || lamp.lived_s() < options.min_duration_s)
    return Verdict::short_track;
  // What is a glint is one to the end; a lamp may pass by where glints would be.
  const double mirrored_share = std::min(lamp.reflected.share(), lamp.reflected.share_of_all());
  const double riding_share = std::min(lamp.on_vehicle.share(), lamp.on_vehicle.share_of_all());
  // Of a light that stays for long, or was in doubt, only the last records are held.
  const auto held = static_cast<double>(lamp.records.size());
  const auto share_of = [&](bool LampRecord::*holds) {
    return static_cast<double>(std::ranges::count_if(lamp.records, holds)) / std::max(held, 1.0);
  };
  const double imaged_share = share_of(&LampRecord::casts_image);
  // What shines on a body has no image on the road below it.
  if (mirrored_share > kShare || (riding_share > kShare && imaged_share < kShare))
    return Verdict::reflection;
  if (lamp.fixed || lamp.above.share() > kShare) return Verdict::static_light;
  constexpr double kRedShare = 0.5;
  if (lamp.kind() == LampKind::other || lamp.lived_s() < options.min_single_lamp_s ||
      (lamp.kind() == LampKind::headlamp && lamp.red.share() > kRedShare))
    return Verdict::undecided;

  // A light that comes from afar is level with the camera for most of the time, if it is below it
  // plainly at the end: that part tells where it drives.
  const std::vector<bool> below = below_the_camera(lamp.records, view);
  const bool level = !tells_by_elevation(lamp.records, below);
  std::vector<double> times_s, along_m, laterals_m, lateral_sigmas_m, doubts, strengths;
  std::vector<double> faint_log_odds;
  int clipped = 0;
  track.sightings.clear();
  for (std::size_t k = 0; k < lamp.records.size(); ++k) {
    const LampRecord& record = lamp.records[k];
    clipped += record.sighting.saturated_px > 0;
    faint_log_odds.push_back(record.faint_tail_log_odds);
    track.sightings.push_back({record.frame, record.time, sighting_of(record), std::nullopt});
    if (!level && !below[k]) continue;
    const LampPlace place = view.place(record.at_px);
    doubts.push_back(view.slope_sigma(place.inverse_depth_per_m) /
                     std::max(std::abs(place.slope_down), 1e-6));
    const RoadPosition at = view.road_at(record.at_px, place.inverse_depth_per_m);
    strengths.push_back(std::log(std::max(record.sighting.flux, 1e-9)) -
                        2.0 * std::log(place.inverse_depth_per_m));
    times_s.push_back(seconds_of(record.time));
    along_m.push_back(at.along_m);
    laterals_m.push_back(at.lateral_m);
    lateral_sigmas_m.push_back(view.lateral_sigma_m(place.inverse_depth_per_m));
  }
  if (held < kFewestSingle) return Verdict::undecided;
  const double clipped_share = clipped / held;
  LoneLight light;
  // What rides on a body has no image on the road.
  light.riding_share = riding_share * (1.0 - imaged_share);
  light.mirrored_share = std::max(mirrored_share, share_of(&LampRecord::streak));
  light.below_share = std::min(lamp.below.share(), lamp.below.share_of_all());
  light.misshapen_share = misshapen_share(lamp.records, view);
  light.unlike_share = 1.0 - lamp.lamp_like.share_of_all();
  light.imaged_share = imaged_share;
  light.unseen_share =
      1.0 - held / static_cast<double>(lamp.records.back().frame - lamp.records.front().frame + 1);
  light.paired_share = lamp.paired_sightings / (lamp.paired_sightings + held);
  // One that elevation tells nothing of must pass by on a course of its own, see below.
  light.off_course_share = level ? 0.0 : off_course_share(lamp.records, view);
  // With an image of its own or without, what rides on a body and has no course of its own is its
  // glint.
  constexpr double kStrays = 0.3;
  if (riding_share > kShare && light.off_course_share > kStrays) return Verdict::reflection;
  light.clipped_share = clipped_share;
  light.lamps_clip = lights.usually_clips(lamp.kind());
  const auto usual = lights.at_least(lamp.kind());
  if (usual) light.strength_ln = median(strengths) - *usual;
  // Beside one or two lamps, or beside tail lamps, only that it is far fainter counts.
  if (light.strength_ln && !lights.knows(lamp.kind()))
    light.strength_ln = std::min(*light.strength_ln, 0.0);
  // One that clips is no lamp for that.
  const double faint_ln = lamp.kind() == LampKind::taillamp ? kFaintSingleTail : kFaintSingle;
  if (too_faint(strengths, lamp.kind(), lights, usual, 0.0,
                {faint_ln + kHiddenByClippingLn * clipped_share, kUnderTailLamps}) ||
      lone_lamp_log_odds(light) < kSureLogOdds)
    return Verdict::undecided;
  const bool comes = view.moving_sensor() && lamp.kind() == LampKind::headlamp &&
                     comes_in_a_lane(lamp.records, view);
  const bool passes = level && !comes && passes_in_a_lane(lamp.records, lamp.kind(), view);
  if (level && !comes && !passes) return Verdict::undecided;
  const double closing_mps = -slope_of(times_s, along_m);
  const double ego_mps = view.ego_speed_mps(times_s.front());
  if (!comes && !passes) {
    const double moved_m = std::abs(closing_mps) * (times_s.back() - times_s.front());
    if (view.moving_sensor()) {
      // A standing light at another height seems to move; only a lane tells it from a vehicle.
      if (!view.off_lane_centre_m(0.0)) return Verdict::undecided;
      const double doubt_mps = kSlow_mps + kSpeedSigmas * median(doubts) * std::abs(closing_mps);
      const double off_mps = std::abs(closing_mps - ego_mps);
      if (off_mps < kSlow_mps || (off_mps < doubt_mps && !(lamp.kind() == LampKind::taillamp &&
                                                           cannot_stand(lamp.records, view))))
        return Verdict::static_light;
    } else if (moved_m < kMoved_m || lamp.wandered_px() < kMoved_px) {
      return Verdict::static_light;
    }
    if (beside_the_road(laterals_m, lateral_sigmas_m, view)) return Verdict::off_road;
  }

  const bool leaves =
      passes ? lamp.kind() == LampKind::taillamp : !comes && closing_mps + kSlow_mps < ego_mps;
  const bool may_be_tail = lights.colourless() || median(faint_log_odds) > kNotWhite;
  track.kind = leaves && !view.moving_sensor() && may_be_tail ? LampKind::taillamp : lamp.kind();
  track.direction = track.kind == LampKind::headlamp ? Direction::oncoming : Direction::receding;
  track.single_lamp = true;
  track.lamps_go_on = false;
  track.ambiguous_identity = lamp.doubtful_at && *lamp.doubtful_at >= lamp.records.front().time;
  track.direction_contradicts =
      !passes &&
      (track.direction == Direction::oncoming ? leaves : closing_mps - kSlow_mps > ego_mps);
  if (view.moving_sensor() && track.direction_contradicts) return Verdict::undecided;
  return Verdict::vehicle;
}

}  // namespace vildar
