#include "simulate/site_plan.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <tuple>

#include "core/random.h"
#include "core/text.h"
#include "estimate/vehicle.h"
#include "optics/camera.h"
#include "optics/channel.h"
#include "optics/incidence.h"
#include "optics/road.h"

namespace vildar::simulate {
namespace {

// What vehicles are like where the site file does not say; only to draw them, never as knowledge.
constexpr double kLampHeight_m = 0.68, kTailHeight_m = 0.8, kSeparation_m = 1.3;
constexpr double kPowerAt_m = 60.0;

/// One vehicle, at constant speed, at the sensor's cross-line at t = 0.
struct Vehicle {
  const LaneSite* lane;
  double speed_mps, height_m, separation_m;

  bool oncoming() const { return lane->direction == Direction::oncoming; }
  double along_m(double t_s) const { return oncoming() ? -speed_mps * t_s : speed_mps * t_s; }
};

Vehicle vehicle_of(const LaneSite& lane, const LampsSite& lamps, double speed_mps) {
  const auto mean = [](const std::optional<Uncertain>& value, double otherwise) {
    return value ? value->mean : otherwise;
  };
  Vehicle vehicle{&lane, speed_mps, mean(lamps.height_m, kLampHeight_m),
                  mean(lamps.separation_m, kSeparation_m)};
  const auto commonest = std::ranges::max_element(lamps.classes, {}, &LampClass::share);
  if (commonest != lamps.classes.end() && (vehicle.oncoming() || lamps.classes_tell_tails())) {
    vehicle.height_m = commonest->height_m.mean;
    vehicle.separation_m = mean(commonest->separation_m, 0.0);
  }
  if (!vehicle.oncoming()) {
    vehicle.height_m = mean(lamps.tail_height_m, kTailHeight_m);
    if (vehicle.separation_m > 0.0)
      vehicle.separation_m = mean(lamps.tail_separation_m, vehicle.separation_m);
    if (lamps.classes_tell_tails()) {
      vehicle.height_m = mean(commonest->tail_height_m, vehicle.height_m);
      vehicle.separation_m = mean(commonest->tail_separation_m, vehicle.separation_m);
    }
  }
  return vehicle;
}

Eigen::Vector3d lamp_m(const Vehicle& vehicle, const RoadSite& road, double side, double t_s) {
  const double bend = road.radius_m ? bend_of(road) : 0.0;
  const auto place = path_point(vehicle.along_m(t_s), vehicle.lane->lateral_m.mean, bend,
                                road.straight_m.mean, road.radius_m ? road.radius_m->mean : 0.0);
  const double offset_m = side * vehicle.separation_m;
  return {place.x_m - offset_m * std::sin(place.heading_rad),
          place.y_m + offset_m * std::cos(place.heading_rad), vehicle.height_m};
}

std::optional<LampSighting> sight(const Vehicle& vehicle, const Site& site, const Camera& camera,
                                  double side, double t_s, double sigma_px, Random& random) {
  const CameraSite& sensor = *site.camera;
  double at_s = t_s;
  std::optional<Eigen::Vector2d> pixel;
  // The row that a lamp is read in depends on where it is then.
  for (int step = 0; step < (sensor.rolling_shutter_s > 0.0 ? 4 : 1); ++step) {
    pixel = camera.project(lamp_m(vehicle, site.road, side, at_s));
    if (!pixel || pixel->x() < 0.0 || pixel->x() > sensor.width_px - 1.0 || pixel->y() < 0.0 ||
        pixel->y() > sensor.height_px - 1.0)
      return std::nullopt;
    at_s = t_s + ((pixel->y() + 0.5) / sensor.height_px - 0.5) * sensor.rolling_shutter_s;
  }
  LampSighting lamp;
  lamp.centre_px = *pixel + sigma_px * Eigen::Vector2d(random.normal(), random.normal());
  lamp.centre_sigma_px.setConstant(sigma_px);
  lamp.row_fraction = (pixel->y() + 0.5) / sensor.height_px - 0.5;
  return lamp;
}

VehicleTrack track_of(const Vehicle& vehicle, const Site& site, const PlanOptions& options,
                      double from_s, double to_s, PlanRow& row, Random& random) {
  const Camera camera(*site.camera);
  VehicleTrack track;
  track.id = 1;
  track.direction = vehicle.lane->direction;
  track.kind = vehicle.oncoming() ? LampKind::headlamp : LampKind::taillamp;
  const int frames = static_cast<int>((to_s - from_s) * options.frame_rate_hz) + 1;
  for (int i = 0; i < frames; ++i) {
    const double t_s = from_s + i / options.frame_rate_hz;
    VehicleSighting sighting;
    sighting.frame = i;
    sighting.time = time_from_seconds<CameraTime>(t_s);
    sighting.left = sight(vehicle, site, camera, 0.5, t_s, options.centroid_sigma_px, random);
    sighting.right = sight(vehicle, site, camera, -0.5, t_s, options.centroid_sigma_px, random);
    if (!sighting.left || !sighting.right) continue;
    const double range_m = lamp_m(vehicle, site.road, 0.0, t_s).x();
    if (track.sightings.empty()) row.from_m = range_m;
    row.to_m = range_m;
    track.sightings.push_back(sighting);
  }
  if (!track.sightings.empty())
    row.seconds =
        seconds_of(track.sightings.back().time) - seconds_of(track.sightings.front().time);
  return track;
}

// One transmitter by the site's power law, or D^-2 where it has none, on a small ambient level.
PowerTrace trace_of(const Vehicle& vehicle, const Site& site, int photodiode,
                    const PlanOptions& options, double from_s, double to_s, Random& random) {
  const PhotodiodeSite& diode = site.photodiodes[static_cast<std::size_t>(photodiode)];
  const Eigen::Vector3d receiver_m(diode.position_m[0].mean, diode.position_m[1].mean,
                                   diode.position_m[2].mean);
  PowerLaw law;
  law.gain_w = 1e-5;
  law.path_loss_exponent = 2.0;
  if (site.channel && site.channel->beam.empty()) {
    if (site.channel->gain_db)
      law.gain_w = ratio_from_db(site.channel->gain_db->mean) * site.channel->lamp_power_w.mean;
    if (site.channel->path_loss_exponent)
      law.path_loss_exponent = site.channel->path_loss_exponent->mean;
  }
  const double reference_w = law.power_w(kPowerAt_m, 0.0);
  PowerTrace trace;
  trace.photodiode = photodiode;
  trace.photodiode_id = diode.id;
  trace.sample_period_s = 1.0 / options.photodiode_rate_hz;
  trace.noise_sigma_w = reference_w * std::pow(10.0, -options.photodiode_snr_db / 20.0);
  trace.ambient_w = 0.1 * reference_w;
  trace.ambient_sigma_w = trace.noise_sigma_w / 20.0;
  const Eigen::Vector3d axis = axis_of(diode);
  const auto samples = static_cast<std::int64_t>((to_s - from_s) * options.photodiode_rate_hz);
  for (std::int64_t i = 0; i < samples; ++i) {
    const double t_s = from_s + static_cast<double>(i) * trace.sample_period_s;
    const Eigen::Vector3d apart_m = lamp_m(vehicle, site.road, 0.0, t_s) - receiver_m;
    const bool seen = apart_m.x() > 0.0 &&
                      axis.dot(apart_m.normalized()) > std::cos(diode.half_field_of_view_rad);
    const double light_w = seen ? law.power_w(apart_m.x(), apart_m.tail<2>().norm()) : 0.0;
    trace.time_s.push_back(t_s - diode.time_offset_s.mean);
    trace.power_w.push_back(
        static_cast<float>(trace.ambient_w + light_w + trace.noise_sigma_w * random.normal()));
  }
  return trace;
}

// Light ends where the vehicle leaves the field of view, before it is abeam.
PowerPass pass_of(const PowerTrace& trace) {
  const auto brightest = std::ranges::max_element(trace.power_w) - trace.power_w.begin();
  return {trace.time_s.front(), trace.time_s.back(),
          trace.time_s[static_cast<std::size_t>(brightest)]};
}

PlanRow plan_pass(const LaneSite& lane, double speed_mps, const Site& site,
                  const PlanOptions& options, std::uint64_t seed) {
  PlanRow row;
  row.lane = lane.id;
  row.speed_mps = speed_mps;
  const Vehicle vehicle = vehicle_of(lane, site.lamps, speed_mps);
  const double span_s = options.farthest_m / speed_mps;
  const double from_s = vehicle.oncoming() ? -span_s : 0.0, to_s = from_s + span_s;
  Random random(seed);
  std::vector<PowerTrace> traces;
  if (vehicle.oncoming())
    for (std::size_t k = 0; k < site.photodiodes.size(); ++k)
      traces.push_back(
          trace_of(vehicle, site, static_cast<int>(k), options, from_s, to_s + 0.5, random));
  if (!site.camera) {
    row.seconds = span_s;
    if (!vehicle.oncoming()) {
      row.result.withheld = Miss::outside_model;
      row.result.warnings.push_back(
          "its vehicles drive away: photodiodes tell the speed of headlamps alone; add a camera");
      return row;
    }
    if (traces.empty() || traces.front().time_s.empty()) {
      row.result.withheld = Miss::too_few_samples;
      return row;
    }
    row.result = estimate_pass(pass_of(traces.front()), 1, site, traces);
    return row;
  }
  std::vector<VehiclePower> power;
  for (const PowerTrace& trace : traces) power.push_back({&trace, false});
  const VehicleTrack track = track_of(vehicle, site, options, from_s, to_s, row, random);
  if (!track.sightings.empty()) {
    row.result = estimate_vehicle(track, site, power).result;
    return row;
  }
  row.result.withheld = Miss::too_few_samples;
  row.result.warnings.push_back(
      "the camera sees no lamp in this lane: check its yaw_deg, pitch_deg and position_m, and the "
      "lane's lateral_m (left of the camera: positive)");
  return row;
}

// Of a few passes that differ in their noise, the one whose sigma is the middle one; a pass that is
// withheld counts as the least sure.
PlanRow plan_lane(const LaneSite& lane, double speed_mps, const Site& site,
                  const PlanOptions& options) {
  constexpr std::uint64_t kPasses = 5;
  std::vector<PlanRow> rows;
  for (std::uint64_t seed = 1; seed <= kPasses; ++seed)
    rows.push_back(plan_pass(lane, speed_mps, site, options, seed));
  const auto middle = rows.begin() + kPasses / 2;
  std::nth_element(rows.begin(), middle, rows.end(), [](const PlanRow& a, const PlanRow& b) {
    const auto sigma = [](const PlanRow& row) {
      return row.result.withheld ? INFINITY : row.result.speed.std_mps;
    };
    return sigma(a) < sigma(b);
  });
  return *middle;
}

// What two photodiodes would give without the camera, where that is surer. Beside it the speed is
// of the time in view, of which light that comes after tells only as much as no vehicle may brake
// in between.
std::optional<SpeedEstimate> surer_alone(const PlanRow& row, const LaneSite& lane, Site site,
                                         const PlanOptions& options) {
  if (!site.camera || site.photodiodes.size() < 2 || lane.direction != Direction::oncoming)
    return std::nullopt;
  site.camera.reset();
  const VehicleResult alone = plan_lane(lane, row.speed_mps, site, options).result;
  const double both_mps = row.result.withheld ? INFINITY : row.result.speed.std_mps;
  if (alone.withheld || !(alone.speed.std_mps < both_mps)) return std::nullopt;
  return alone.speed;
}

}  // namespace

std::vector<std::string> PlanOptions::problems() const {
  std::vector<std::string> found;
  const auto positive = [&](const char* name, double value) {
    if (!(value > 0.0 && std::isfinite(value)))
      found.push_back(std::string(name) + " = " + told_number(value) + ", must be > 0");
  };
  for (const double speed_kmh : speeds_kmh) positive("speeds_kmh", speed_kmh);
  positive("frame_rate_hz", frame_rate_hz);
  positive("centroid_sigma_px", centroid_sigma_px);
  positive("farthest_m", farthest_m);
  positive("photodiode_rate_hz", photodiode_rate_hz);
  const auto at_most = [&](const char* name, double value, double most) {
    if (value > most)
      found.push_back(std::string(name) + " = " + number_text(value) + ", must be at most " +
                      number_text(most));
  };
  at_most("frame_rate_hz", frame_rate_hz, 10e3);
  at_most("farthest_m", farthest_m, 2e3);
  at_most("photodiode_rate_hz", photodiode_rate_hz, 1e6);
  if (!std::isfinite(photodiode_snr_db)) found.push_back("photodiode_snr_db must be a number");
  if (!found.empty()) return found;
  constexpr double kMostFrames = 20e3, kMostSamples = 1e6;  // some ten seconds each
  for (const double speed_kmh : speeds_kmh) {
    const double way_s = 3.6 * farthest_m / speed_kmh;
    for (const auto& [what, rate_hz, most] : {std::tuple("frames", frame_rate_hz, kMostFrames),
                                              {"samples", photodiode_rate_hz, kMostSamples}})
      if (way_s * rate_hz > most)
        found.push_back("speeds_kmh = " + number_text(speed_kmh) + ", takes " +
                        fixed_text(way_s, 0) + " s over farthest_m, " +
                        fixed_text(way_s * rate_hz, 0) + " " + what + "; must be at most " +
                        number_text(most));
  }
  return found;
}

std::vector<PlanRow> plan_site(const Site& site, const PlanOptions& options) {
  if (site.ego)
    throw std::invalid_argument("plan_site: a dashcam has no lanes to plan for; leave `ego` out");
  if (site.road.lanes.empty())
    throw std::invalid_argument("plan_site: the site has no lanes; add road.lanes");
  std::vector<PlanRow> rows;
  for (const LaneSite& lane : site.road.lanes) {
    for (const double speed_kmh : options.speeds_kmh) {
      PlanRow& row =
          rows.emplace_back(plan_lane(lane, speed_kmh / kmh_from_mps(1.0), site, options));
      row.light_alone = surer_alone(row, lane, site, options);
    }
  }
  return rows;
}

}  // namespace vildar::simulate
