#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "core/text.h"
#include "estimate/contradictions.h"
#include "estimate/delay_light.h"
#include "estimate/lane_choice.h"
#include "estimate/light_checks.h"
#include "estimate/ml_speed.h"
#include "estimate/pass_delay.h"
#include "estimate/photodiode_speed.h"
#include "estimate/speed_gate.h"
#include "estimate/vehicle.h"

namespace vildar {
namespace {

// Where a vehicle drives, as far as that is known without a camera.
struct Abreast {
  std::vector<const LaneSite*> lanes;  // it may be in any of these
  Uncertain lateral_m;

  // The one lane, if there is one.
  const LaneSite* lane() const { return lanes.size() == 1 ? lanes.front() : nullptr; }
};

// Any lane whose headlamps face the photodiode, all alike likely: how far to the side it drives,
// taken to the side of the first.
Abreast abreast_of(const RoadSite& road, double receiver_y_m) {
  Abreast found;
  double sum_m = 0.0, square_m2 = 0.0;
  for (const LaneSite& lane : road.lanes) {
    if (lane.direction != Direction::oncoming) continue;
    found.lanes.push_back(&lane);
    const Uncertain lateral_m = lane_prior_m(lane);
    const double apart_m = std::abs(lateral_m.mean - receiver_y_m);
    sum_m += apart_m;
    square_m2 += apart_m * apart_m + lateral_m.std * lateral_m.std;
  }
  if (found.lanes.empty()) return found;
  const auto n = static_cast<double>(found.lanes.size());
  const double mean_m = sum_m / n;
  const bool right = found.lanes.front()->lateral_m.mean < receiver_y_m;
  found.lateral_m = {receiver_y_m + (right ? -mean_m : mean_m),
                     std::sqrt(std::max(0.0, square_m2 / n - mean_m * mean_m))};
  return found;
}

// The stretch of one trace in which the power laws hold, and what is known of it.
struct KnownLight {
  VehicleLight light;
  PowerCase known;
};

// Vehicles behind are further away before this one is past than when it is: they add less than
// `others_w`, but of a shape that looks like a slower vehicle. What they add more than a twentieth
// to is left out; in the rest it is a constant background, not known better than it is bright.
void keep_own_light(PowerSeries& series, double others_w) {
  constexpr double kTimesOthers = 20.0;
  constexpr double kMean_s = 0.010;
  std::size_t first = series.time_s.size();
  double sum_w = 0.0;
  for (std::size_t from = first, to = first; from-- > 0;) {
    sum_w += series.power_w[from];
    while (series.time_s[to - 1] - series.time_s[from] > kMean_s) sum_w -= series.power_w[--to];
    if (sum_w < kTimesOthers * others_w * static_cast<double>(to - from)) break;
    first = from;
  }
  const auto cut = static_cast<std::ptrdiff_t>(first);
  series.time_s.erase(series.time_s.begin(), series.time_s.begin() + cut);
  series.power_w.erase(series.power_w.begin(), series.power_w.begin() + cut);
  series.background_std_w = std::hypot(series.background_std_w, others_w);
}

// Of what begins with a good part of its brightest light only the peak is left: there lamps are
// least alike, and any of another beam looks like one that drives slower or faster.
bool begins_near(const PowerSeries& series) {
  constexpr double kMostAtFirst = 0.25;
  constexpr Eigen::Index kFirst = 10;
  const Eigen::Map<const Eigen::VectorXd> power_w(series.power_w.data(),
                                                  std::ssize(series.power_w));
  return power_w.head(kFirst).mean() > kMostAtFirst * power_w.maxCoeff();
}

// At its peak brighter than a lamp abreast may be by the law and what is not known of its gain and
// of its place, by how many times.
std::optional<double> times_too_bright(const PowerCase& known, double peak_w) {
  constexpr double kSigmas = 3.0;
  if (known.bend != 0.0) return std::nullopt;
  const double d_m = known.perpendicular_m(), exponent = known.law.path_loss_exponent;
  const double aside_m = known.lateral_m.mean - known.receiver_m.y();
  const double below_m = known.receiver_m.z() - known.lamp_height_m.mean;
  const double log_std =
      std::hypot(known.log_gain_std, exponent * aside_m * known.lateral_m.std / (d_m * d_m),
                 exponent * below_m * known.lamp_height_m.std / (d_m * d_m));
  const double times = peak_w / (known.law.gain_w * std::pow(d_m, -exponent));
  return times > std::exp(kSigmas * log_std) ? std::optional(times) : std::nullopt;
}

// Leaves what is the vehicle's alone, or says why that is too little.
std::optional<Miss> lack_of_own_light(VehicleLight& light, double others_w) {
  constexpr double kShortest_s = 0.1;
  constexpr std::size_t kFewest = 10;
  const PowerSeries& series = light.series;
  if (series.time_s.size() < kFewest) return Miss::too_few_samples;
  if (others_w > 0.0) {
    keep_own_light(light.series, others_w);
    light.cleared = light.series;  // light of others is no level that a fit could tell
    if (series.time_s.size() < kFewest || begins_near(series)) return Miss::several_vehicles;
  }
  if (series.time_s.back() - series.time_s.front() < kShortest_s) return Miss::too_short;
  return std::nullopt;
}

Outcome<KnownLight> light_of_pass(const SeenPass& seen, const Site& site, const Abreast& abreast,
                                  std::vector<std::string>& warnings) {
  const PowerPass& pass = seen.pass;
  const PowerTrace& trace = *seen.trace;
  if (abreast.lanes.empty() && !site.road.lanes.empty()) return Miss::outside_model;
  if (abreast.lanes.empty() || !site.lamps.height_m) return Miss::no_scale;
  const auto known =
      photodiode_case(site, trace.photodiode, {abreast.lateral_m, *site.lamps.height_m});
  if (const Miss* miss = std::get_if<Miss>(&known)) return *miss;
  KnownLight found;
  found.known = std::get<PowerCase>(known);
  found.known.log_gain_std =
      std::hypot(found.known.log_gain_std, log_light_std(trace, pass.from_s, pass.peak_s));
  const double offset_s =
      site.photodiodes.at(static_cast<std::size_t>(trace.photodiode)).time_offset_s.mean;
  found.light = vehicle_light(trace, site, found.known, pass.from_s + offset_s,
                              pass.peak_s + offset_s, nullptr);
  const auto lack = lack_of_own_light(found.light, pass.others_w);
  constexpr double kNoiseSigmas = 5.0;
  const auto times =
      times_too_bright(found.known, seen.peak_w - kNoiseSigmas * trace.noise_sigma_w);
  if (times)
    warnings.push_back(
        "its light is up to " + fixed_text(*times, 1) +
        " times that of a lamp abreast of the photodiode as the channel tells it, and a speed "
        "from it too low: check channel.gain_db and lamp_power_w, the unit of the trace (W, A, "
        "V), responsivity_a_per_w and transimpedance_v_per_a");
  // Where it seems to be nearer than the lane is, no light is left.
  if (lack) return times ? Miss::outside_model : *lack;
  // Beside several lanes it may be the light of two, of which none is told from one that is nearer.
  constexpr double kOfTwo = 0.35;  // ln 2 is two sigmas
  if (!abreast.lane()) found.known.log_gain_std = std::hypot(found.known.log_gain_std, kOfTwo);
  return found;
}

// What a method found, beside the row it gets.
struct Found {
  MethodResult row;
  std::optional<double> range_m, acceleration_mps2, chi2_per_dof;
  bool beside_others = false;  ///< whether light without delay was told apart
};

Found power_method(Method method, const Outcome<KnownLight>& light, PowerSeries VehicleLight::*part,
                   Outcome<PowerSpeed> (*speed_of)(const PowerSeries&, const PowerCase&)) {
  Found found{{method, Miss::unobservable, 0, "site"}, {}, {}, {}};
  if (const Miss* miss = std::get_if<Miss>(&light)) {
    found.row.speed = *miss;
    return found;
  }
  const auto& [own, known] = std::get<KnownLight>(light);
  const PowerSeries& series = own.*part;
  found.row.samples = static_cast<std::int64_t>(series.time_s.size());
  const auto outcome = speed_of(series, known);
  if (const Miss* miss = std::get_if<Miss>(&outcome)) {
    found.row.speed = *miss;
  } else {
    found.row.speed = std::get<PowerSpeed>(outcome).speed;
    found.range_m = std::get<PowerSpeed>(outcome).range_m;
  }
  return found;
}

Found delay_method(const SeenPass& seen, const Site& site, std::span<const PowerTrace> traces,
                   std::size_t lanes) {
  const auto outcome = pass_delay(seen, site, traces, lanes);
  Found found{delay_row(outcome), {}, {}, {}};
  if (const auto* fit = std::get_if<DelayFit>(&outcome)) {
    found.acceleration_mps2 = fit->acceleration_mps2;
    found.chi2_per_dof = fit->chi2_per_dof;
    found.beside_others = fit->common_lights > 0;
  }
  return found;
}

// Whether of the light of a pass, and of what was clipped next to it, more was clipped than not.
bool mostly_clipped(const PowerPass& pass, const PowerTrace& trace) {
  constexpr double kNextTo_s = 0.05;
  double clipped_s = 0.0, in_pass_s = 0.0;
  for (const auto& [from_s, to_s] : trace.clipped) {
    if (to_s < pass.from_s - kNextTo_s || from_s > pass.to_s + kNextTo_s) continue;
    clipped_s += to_s - from_s;
    in_pass_s += std::max(0.0, std::min(to_s, pass.to_s) - std::max(from_s, pass.from_s));
  }
  return clipped_s > pass.to_s - pass.from_s - in_pass_s;
}

bool is_lack_of_light(Miss miss) {
  return miss == Miss::too_few_samples || miss == Miss::too_short || miss == Miss::below_noise ||
         miss == Miss::too_uncertain;
}

// Where no method's speed stands: photodiodes that deny what the site says of them, else the first
// reason but that the site gives a method no scale.
const MethodResult& withheld_by(const std::vector<Found>& methods) {
  const auto first = [&](auto&& is_it) {
    return std::ranges::find_if(methods, [&](const Found& found) {
      const Miss* miss = std::get_if<Miss>(&found.row.speed);
      return miss && is_it(*miss);
    });
  };
  auto reason = first([](Miss miss) { return miss == Miss::sensors_contradict; });
  if (reason == methods.end()) reason = first([](Miss miss) { return miss != Miss::no_scale; });
  if (reason == methods.end()) reason = first([](Miss) { return true; });
  assert(reason != methods.end());
  return reason->row;
}

// Light that no lamp under the channel's law explains, as a street lamp's or a cloud's: what else
// rests on that law tells nothing either.
bool law_is_denied(const std::vector<Found>& methods) {
  return std::ranges::any_of(methods, [](const Found& found) {
    const Miss* miss = std::get_if<Miss>(&found.row.speed);
    return found.row.method == Method::ml_photodiode && miss && *miss == Miss::bad_fit;
  });
}

// Lamps are unlike the law in more ways than the likelihood's family of beams holds: it stands only
// where the paper's estimator, whose sigma holds more of them, has no speed, or none of use and is
// hardly less sure: then its sigma says little more of such beams than the likelihood's.
bool likelihood_stands(const std::vector<Found>& methods) {
  constexpr double kHardlySurer = 0.8;
  const SpeedEstimate* slope = nullptr;
  const SpeedEstimate* likeliest = nullptr;
  for (const Found& found : methods) {
    const auto* speed = std::get_if<SpeedEstimate>(&found.row.speed);
    if (found.row.method == Method::ml_photodiode)
      likeliest = speed;
    else if (found.row.method != Method::delay_photodiodes)
      slope = speed;
  }
  return !slope ||
         (likeliest && !useful(*slope) && likeliest->std_mps > kHardlySurer * slope->std_mps);
}

// The surest of the methods that measured.
void stand_by_surest(const std::vector<Found>& methods, VehicleResult& result) {
  const bool law_denied = law_is_denied(methods);
  const bool likelihood = likelihood_stands(methods);
  const Found* surest = nullptr;
  for (const Found& found : methods) {
    result.methods.push_back(found.row);
    const auto* speed = std::get_if<SpeedEstimate>(&found.row.speed);
    if (speed && too_fast(*speed)) result.methods.back().speed = Miss::outside_model;
    if (law_denied && found.row.method != Method::delay_photodiodes) continue;
    if (!likelihood && found.row.method == Method::ml_photodiode) continue;
    if (speed && (!surest || speed->std_mps < std::get<SpeedEstimate>(surest->row.speed).std_mps))
      surest = &found;
  }
  const bool mixed = std::ranges::any_of(methods, [](const Found& found) {
    const Miss* miss = std::get_if<Miss>(&found.row.speed);
    return miss && *miss == Miss::several_vehicles && found.row.method == Method::delay_photodiodes;
  });
  // Where they contradict each other, the delay stands: no lamp and no channel enters it.
  for (const Found& found : methods) {
    const auto* speed = std::get_if<SpeedEstimate>(&found.row.speed);
    if (speed && found.row.method == Method::delay_photodiodes && useful(*speed) &&
        apart(*speed, std::get<SpeedEstimate>(surest->row.speed)))
      surest = &found;
  }
  if (mixed) {
    result.method = Method::delay_photodiodes;
    result.withheld = Miss::several_vehicles;
    return;
  }
  if (!surest) {
    const MethodResult& row = withheld_by(methods);
    result.method = row.method;
    result.withheld = std::get<Miss>(row.speed);
    return;
  }
  result.method = surest->row.method;
  result.speed = std::get<SpeedEstimate>(surest->row.speed);
  result.n_pd_samples = surest->row.samples;
  if (surest->beside_others)
    result.warnings.push_back(
        "light of other lamps came or went on both photodiodes at once while the vehicle passed: "
        "the delay is of what came to one after the other; power_slope and ml_photodiode are not");
  if (too_fast(result.speed)) {
    result.withheld = Miss::outside_model;
    result.warnings.push_back(warning_of_too_fast(result.method, result.speed));
    return;
  }
  // Slow is what a law says of light that hardly changes, whatever it comes of.
  constexpr double kMostShare = 0.4;
  if (!useful(result.speed) || result.speed.std_mps > kMostShare * result.speed.speed_mps) {
    result.withheld = Miss::too_uncertain;
    return;
  }
  result.closing_speed_mps = result.speed.speed_mps;
  result.range_ref_m = surest->range_m;
  result.acceleration_mps2 = surest->acceleration_mps2;
  if (surest->chi2_per_dof) result.chi2_per_dof["photodiode"] = *surest->chi2_per_dof;
}

// A method that the others contradict by more than their intervals is named.
void warn_of_contradictions(VehicleResult& result) {
  if (result.withheld) return;
  for (const MethodResult& row : result.methods) {
    const auto* speed = std::get_if<SpeedEstimate>(&row.speed);
    if (!speed || row.method == result.method) continue;
    if (apart(*speed, result.speed))
      result.warnings.push_back(std::string(name_of(row.method)) + " disagrees with " +
                                std::string(name_of(result.method)) +
                                " beyond their intervals; check the channel and the lanes");
  }
}

}  // namespace

VehicleResult estimate_pass(const PowerPass& found, int pass_number, const Site& site,
                            std::span<const PowerTrace> traces) {
  if (traces.empty()) throw std::invalid_argument("estimate_pass: no photodiode trace given");
  const SeenPass seen = best_seen(found, site, traces);
  const PowerTrace& trace = *seen.trace;
  const PowerPass& pass = seen.pass;
  const PhotodiodeSite& receiver = site.photodiodes.at(static_cast<std::size_t>(trace.photodiode));
  const Abreast abreast = abreast_of(site.road, receiver.position_m[1].mean);
  const LaneSite* lane = abreast.lane();
  const double offset_s = receiver.time_offset_s.mean;
  VehicleResult result;
  result.track_id = pass_number;
  result.t_first_s = pass.from_s + offset_s;
  result.t_last_s = pass.to_s + offset_s;
  result.used_photodiode = true;
  if (lane) result.lane = lane->id;
  const bool curved = site.road.kind == RoadKind::curved;
  const bool pulsed = pulses(trace, pass.from_s, pass.peak_s);
  if (pulsed)
    result.warnings.push_back(
        "the light jumps from sample to sample, as of lamps that pulse: at this rate its mean "
        "cannot be trusted; a camera beside the photodiodes measures such vehicles");
  const bool stops = !pulsed && stands(trace, pass.from_s, pass.peak_s);
  if (stops)
    result.warnings.push_back(
        "its light stays the same for a while: the vehicle stands, and the power laws are of one "
        "that drives steadily; a camera measures it where it drives");
  const bool flashes = !pulsed && found.comes_again_s > 0.0;
  if (flashes)
    result.warnings.push_back("the same light comes every " + fixed_text(found.comes_again_s, 2) +
                              " s: lamps that flash or turn, no vehicle");
  if (pass.cut_off)
    result.warnings.push_back(
        "the record ends or stops before the vehicle is past: the light of others behind it is not "
        "known");
  const auto light = pulsed || stops || flashes
                         ? Outcome<KnownLight>(Miss::outside_model)
                         : light_of_pass(seen, site, abreast, result.warnings);
  std::vector<Found> methods{
      power_method(curved ? Method::curved_angle_photodiode : Method::power_slope_photodiode, light,
                   &VehicleLight::cleared, power_speed),
      power_method(Method::ml_photodiode, light, &VehicleLight::series, ml_speed)};
  if (traces.size() > 1)
    methods.push_back(
        pulsed || flashes
            ? Found{{Method::delay_photodiodes, Miss::outside_model, 0, ""}, {}, {}, {}}
            : delay_method(seen, site, traces, abreast.lanes.size()));
  const bool clipped = mostly_clipped(pass, trace);
  for (Found& one : methods)
    if (const Miss* miss = std::get_if<Miss>(&one.row.speed);
        clipped && miss && is_lack_of_light(*miss))
      one.row.speed = Miss::saturated;
  stand_by_surest(methods, result);
  if (clipped && result.withheld && is_lack_of_light(*result.withheld))
    result.withheld = Miss::saturated;
  // Two photodiodes tell by the order in which they see it which way a vehicle drives.
  if (result.withheld && abreast.lanes.empty() && !site.road.lanes.empty()) {
    result.direction = Direction::receding;
    result.warnings.push_back(
        "no lane of the site is oncoming, and the power laws are those of headlamps that come: a "
        "camera measures vehicles that drive away");
  }
  constexpr double kOthersMatter = 0.01;  // of the brightest light
  const bool explained = result.withheld == Miss::no_scale ||
                         result.withheld == Miss::outside_model ||
                         result.withheld == Miss::saturated;
  if (result.withheld && !explained && pass.others_w > kOthersMatter * seen.peak_w)
    result.withheld = Miss::several_vehicles;
  if (!result.withheld && lane && !curved) result.lateral_m = lane->lateral_m.mean;
  warn_of_contradictions(result);
  if (result.withheld == Miss::sensors_contradict)
    result.warnings.push_back(
        "the light of the photodiodes is not alike by as much as the site says of them; check "
        "gain_ratio and its std, and that both are sampled at the same times");
  if (result.withheld == Miss::no_scale)
    result.warnings.push_back(
        "speed is unobservable: light alone needs channel.gain_db and path_loss_exponent with "
        "lamps.height_m and a lane, or a second photodiode a known distance up the road");
  return result;
}

}  // namespace vildar
