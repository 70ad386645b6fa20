#include "estimate/pass_light.h"

#include <cmath>
#include <utility>

#include "estimate/vector_math.h"
#include "estimate/wander.h"
#include "optics/road.h"

namespace vildar {
namespace {

constexpr std::size_t kWidth = kBeamWaves, kTilt = kBeamWaves + 1;  // shapes after the cosines
constexpr double kBlock_s = 0.010;
constexpr double kPerRad = kPi / kBeamEdge_rad;  // of the first cosine
const double kAccelerationStd_mps2 = std::sqrt(kAccelerationVariance_m2ps4);

struct Place {
  Eigen::Vector3d toward_m = Eigen::Vector3d::Zero();  ///< from the receiver
  double arc_rad = 0.0;                                ///< of the bend behind it
  double off_axis_rad = 0.0;                           ///< of the receiver as seen from the vehicle
  double elevation_rad = 0.0;                          ///< of the vehicle
  double sine = 0.0, cosine = 0.0;                     ///< the first of the beam's waves
};

PathPoint<double> point_at(const PowerCase& known, const PassMotion& motion, double time_s) {
  const double tau_s = time_s - motion.reference_s;
  const double along_m =
      motion.along_m - tau_s * (motion.speed_mps + 0.5 * motion.acceleration_mps2 * tau_s);
  return path_point(along_m, known.lateral_m.mean, known.bend, known.straight_m.mean,
                    known.radius_m.mean);
}

// How a place moves with an unknown, and how its path's heading turns.
struct Shift {
  Eigen::Vector3d moved;
  double turned = 0.0;
};

Shift by_path_length(const PowerCase& known, const Place& place) {
  if (place.arc_rad == 0.0) return {Eigen::Vector3d::UnitX()};
  return {{std::cos(place.arc_rad), known.bend * std::sin(place.arc_rad), 0.0},
          known.bend / known.lane_radius_m()};
}

Shift by_radius(const PowerCase& known, const Place& place) {
  const double arc_rad = place.arc_rad;
  if (arc_rad == 0.0) return {Eigen::Vector3d::Zero()};
  const double sine = std::sin(arc_rad), cosine = std::cos(arc_rad);
  return {{sine - arc_rad * cosine, known.bend * (1.0 - cosine - arc_rad * sine), 0.0},
          -known.bend * arc_rad / known.lane_radius_m()};
}

// The bend and all on it move ahead, and what is at the same path length stands earlier on it.
Shift by_straight(const PowerCase& known, const Place& place) {
  if (place.arc_rad == 0.0) return {Eigen::Vector3d::Zero()};
  const auto [forward, turned] = by_path_length(known, place);
  return {Eigen::Vector3d::UnitX() - forward, -turned};
}

// Lanes are concentric: one nearer the bend's centre has a shorter radius.
Shift by_lateral(const PowerCase& known, const Place& place) {
  const auto [moved, turned] = by_radius(known, place);
  return {Eigen::Vector3d::UnitY() - known.bend * moved, -known.bend * turned};
}

// cos(k x) by its recurrence in k.
BeamShapes shapes_at(const Place& place) {
  const double first = place.cosine;
  BeamShapes shapes;
  double before = 1.0, now = first;
  for (std::size_t k = 0; k < kBeamWaves; ++k) {
    shapes[k] = now;
    now = 2.0 * first * now - std::exchange(before, now);
  }
  shapes[kWidth] = place.off_axis_rad * place.off_axis_rad;
  shapes[kTilt] = place.elevation_rad;
  return shapes;
}

// The slope by the azimuth of a sum of these shapes with such weights.
double slope_by_off_axis(const BeamShapes& weights, const Place& place) {
  const double cosine = place.cosine;
  double slope = 2.0 * weights[kWidth] * place.off_axis_rad, before = 0.0, now = place.sine;
  for (std::size_t k = 0; k < kBeamWaves; ++k) {
    slope -= weights[k] * static_cast<double>(k + 1) * kPerRad * now;
    now = 2.0 * cosine * now - std::exchange(before, now);
  }
  return slope;
}

std::vector<Place> places_of(const PowerCase& known, const PassMotion& motion,
                             std::span<const double> time_s) {
  const std::size_t n = time_s.size();
  std::vector<Place> places(n);
  std::vector<double> aside(n), up(n), sine(n), cosine(n);  // tangents, then angles
  for (std::size_t i = 0; i < n; ++i) {
    const auto point = point_at(known, motion, time_s[i]);
    places[i].toward_m =
        Eigen::Vector3d(point.x_m, point.y_m, known.lamp_height_m.mean) - known.receiver_m;
    places[i].arc_rad = known.bend * point.heading_rad;
    aside[i] = places[i].toward_m.y() / places[i].toward_m.x();
    up[i] = places[i].toward_m.z() / places[i].toward_m.head<2>().norm();
  }
  arctangents(aside, aside);
  arctangents(up, up);
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3d& toward_m = places[i].toward_m;
    const double azimuth_rad =
        toward_m.x() > 0.0 ? aside[i] : std::atan2(toward_m.y(), toward_m.x());
    places[i].off_axis_rad = azimuth_rad - known.bend * places[i].arc_rad;
    places[i].elevation_rad = up[i];
    aside[i] = kPerRad * places[i].off_axis_rad;
  }
  sines(aside, sine);
  cosines(aside, cosine);
  for (std::size_t i = 0; i < n; ++i) {
    places[i].sine = sine[i];
    places[i].cosine = cosine[i];
  }
  return places;
}

// The shapes at each place; where K was fitted to the light itself, less what went into it.
std::vector<BeamShapes> shapes_of(const PowerCase& known, const std::vector<Place>& places) {
  std::vector<BeamShapes> shapes;
  shapes.reserve(places.size());
  BeamShapes mean{};
  for (const Place& place : places) {
    shapes.push_back(shapes_at(place));
    for (std::size_t k = 0; k < kBeamShapes; ++k)
      mean[k] += shapes.back()[k] / static_cast<double>(places.size());
  }
  if (!known.log_gain_per_exponent) return shapes;
  for (auto& at : shapes)
    for (std::size_t k = 0; k < kBeamShapes; ++k) at[k] -= mean[k];
  return shapes;
}

// Noise from third differences, which the rise of the light hardly enters.
double noise_w(const PowerSeries& series) {
  double sum_w2 = 0.0;
  const auto& p = series.power_w;
  for (std::size_t i = 3; i < p.size(); ++i)
    sum_w2 += std::pow(p[i] - 3.0 * p[i - 1] + 3.0 * p[i - 2] - p[i - 3], 2) / 20.0;
  return std::sqrt(sum_w2 / static_cast<double>(p.size() - 3));
}

BeamShapes weights_of(const Eigen::VectorXd& z, double ripple_nat) {
  BeamShapes weights;
  for (std::size_t k = 0; k < kBeamShapes; ++k)
    weights[k] = z[kShape + static_cast<int>(k)] * beam_shape_std(ripple_nat, k);
  return weights;
}

}  // namespace

double beam_shape_std(double ripple_nat, std::size_t shape) {
  constexpr double kOfHeadlamps = 4.0;
  return is_smooth(shape) ? kOfHeadlamps * ripple_nat : ripple_nat / static_cast<double>(shape + 1);
}

struct PassLight::Light {
  std::vector<Place> places;
  std::vector<BeamShapes> shapes;
  std::vector<double> log_distance2;
  std::vector<double> power_w;
};

std::vector<BeamShapes> beam_shapes(const PowerCase& known, const PassMotion& motion,
                                    std::span<const double> time_s) {
  return shapes_of(known, places_of(known, motion, time_s));
}

PassLight::PassLight(const PowerSeries& series, const PowerCase& known, const PassMotion& motion)
    : blocks_(series_blocks(series, kBlock_s, noise_w(series))),
      known_(known),
      motion_(motion),
      ahead_m_(point_at(known, motion, motion.reference_s).x_m - known.receiver_m.x()),
      background_std_w_(series.background_std_w) {}

std::optional<Residuals> PassLight::residuals(const Eigen::VectorXd& z, double ripple_nat,
                                              bool with_slopes) const {
  const auto light = light_of(z, motion_of(z), ripple_nat);
  if (!light) return std::nullopt;
  const auto n = static_cast<Eigen::Index>(blocks());
  Residuals found;
  found.values.resize(n + kPassPriors);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto at = static_cast<std::size_t>(i);
    found.values[i] = (light->power_w[at] + z[kDark] * background_std_w_ - blocks_.power_w[at]) /
                      blocks_.sigma_w[at];
  }
  found.values.tail(kPassPriors) = z.tail(kPassPriors);
  found.cost = 0.5 * found.values.squaredNorm();
  if (!with_slopes) return found;
  found.slopes = Eigen::MatrixXd::Zero(kPassUnknowns, n + kPassPriors);
  found.slopes.block(kSpeedingUp, n, kPassPriors, kPassPriors).setIdentity();
  add_log_slopes_of_places(z, ripple_nat, *light, found.slopes);
  for (std::size_t i = 0; i < blocks(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    const double share = light->power_w[i] / blocks_.sigma_w[i];
    found.slopes.col(column).head(kGain) *= share;
    found.slopes(kGain, column) = share * known_.log_gain_std;
    found.slopes(kDark, column) = background_std_w_ / blocks_.sigma_w[i];
    for (std::size_t k = 0; k < kBeamShapes; ++k)
      found.slopes(kShape + static_cast<Eigen::Index>(k), column) =
          share * light->shapes[i][k] * beam_shape_std(ripple_nat, k);
  }
  return found;
}

Eigen::VectorXd PassLight::nearest_to(const PassMotion& motion) {
  Eigen::VectorXd z = Eigen::VectorXd::Zero(kPassUnknowns);
  z[kSpeedingUp] = motion.acceleration_mps2 / kAccelerationStd_mps2;
  return z;
}

PassMotion PassLight::motion_of(const Eigen::VectorXd& z) const {
  PassMotion motion = motion_;
  motion.speed_mps *= std::exp(z[kLogSpeed]);
  motion.along_m += ahead_m_ * std::expm1(z[kLogAlong]);
  motion.acceleration_mps2 = kAccelerationStd_mps2 * z[kSpeedingUp];
  return motion;
}

PowerCase PassLight::known_of(const Eigen::VectorXd& z) const {
  PowerCase known = known_;
  const double steeper = known.exponent_std * z[kGamma];
  known.law.path_loss_exponent += steeper;
  known.law.gain_w *=
      std::exp(known.log_gain_std * z[kGain] + steeper * known.log_gain_per_exponent.value_or(0.0));
  known.lateral_m.mean += known.lateral_m.std * z[kAside];
  known.lamp_height_m.mean += known.lamp_height_m.std * z[kHeight];
  known.radius_m.mean += known.radius_m.std * z[kRadius];
  known.straight_m.mean += known.straight_m.std * z[kStraightLength];
  return known;
}

std::optional<PassLight::Light> PassLight::light_of(const Eigen::VectorXd& z,
                                                    const PassMotion& motion,
                                                    double ripple_nat) const {
  const PowerCase known = known_of(z);
  if (!(known.law.path_loss_exponent > 0.0)) return std::nullopt;
  if (known.bend != 0.0 && !(known.lane_radius_m() > 0.0)) return std::nullopt;
  Light light{places_of(known, motion, blocks_.time_s), {}, {}, {}};
  for (const Place& place : light.places)
    if (!(place.toward_m.x() > 0.0)) return std::nullopt;
  light.shapes = shapes_of(known, light.places);
  const BeamShapes weights = weights_of(z, ripple_nat);
  const PowerLaw& law = known.law;
  std::vector<double> log_ahead;
  for (const Place& place : light.places) {
    light.log_distance2.push_back(place.toward_m.squaredNorm());
    log_ahead.push_back(place.toward_m.x());
  }
  natural_logs(light.log_distance2, light.log_distance2);
  natural_logs(log_ahead, log_ahead);
  const double fall = 0.5 * (law.path_loss_exponent + law.cosine_exponent);
  for (std::size_t i = 0; i < blocks(); ++i) {
    double log_power = law.cosine_exponent * log_ahead[i] - fall * light.log_distance2[i];
    for (std::size_t k = 0; k < kBeamShapes; ++k) log_power += weights[k] * light.shapes[i][k];
    light.power_w.push_back(log_power);
  }
  exponentials(light.power_w, light.power_w);
  for (double& power_w : light.power_w) power_w *= law.gain_w;
  return light;
}

// Of ln of the light, by all that moves the vehicle and by gamma.
void PassLight::add_log_slopes_of_places(const Eigen::VectorXd& z, double ripple_nat,
                                         const Light& light, Eigen::MatrixXd& slopes) const {
  const PassMotion motion = motion_of(z);
  const PowerCase known = known_of(z);
  const PowerLaw& law = known.law;
  const BeamShapes weights = weights_of(z, ripple_nat);
  const double along_m = ahead_m_ * std::exp(z[kLogAlong]);
  Eigen::Vector<double, kGain> mean = Eigen::Vector<double, kGain>::Zero();
  for (std::size_t i = 0; i < blocks(); ++i) {
    const Place& place = light.places[i];
    const double per_distance2 = 1.0 / place.toward_m.squaredNorm();
    Eigen::Vector3d fall =
        -(law.path_loss_exponent + law.cosine_exponent) * per_distance2 * place.toward_m;
    fall.x() += law.cosine_exponent / place.toward_m.x();
    const double by_off_axis = slope_by_off_axis(weights, place);
    const double level_m = place.toward_m.head<2>().norm();
    const double per_level = 1.0 / level_m, per_level2 = per_level * per_level;
    auto column = slopes.col(static_cast<Eigen::Index>(i));
    const auto add = [&](PassUnknown unknown, const Shift& shift, double per_unknown) {
      const auto& [moved, turned] = shift;
      const double swung =
          (place.toward_m.x() * moved.y() - place.toward_m.y() * moved.x()) * per_level2 - turned;
      const double out_m = place.toward_m.head<2>().dot(moved.head<2>()) * per_level;
      const double raised = (level_m * moved.z() - place.toward_m.z() * out_m) * per_distance2;
      const double unlike = per_unknown * (by_off_axis * swung + weights[kTilt] * raised);
      column[unknown] = per_unknown * fall.dot(moved) + unlike;
      mean[unknown] += unlike / static_cast<double>(blocks());
    };
    const double tau_s = blocks_.time_s[i] - motion.reference_s;
    const Shift forward = by_path_length(known, place);
    add(kLogSpeed, forward, -tau_s * motion.speed_mps);
    add(kLogAlong, forward, along_m);
    add(kSpeedingUp, forward, -0.5 * tau_s * tau_s * kAccelerationStd_mps2);
    add(kAside, by_lateral(known, place), known.lateral_m.std);
    add(kHeight, {Eigen::Vector3d::UnitZ()}, known.lamp_height_m.std);
    if (known.bend != 0.0) {
      add(kRadius, by_radius(known, place), known.radius_m.std);
      add(kStraightLength, by_straight(known, place), known.straight_m.std);
    }
    column[kGamma] = known.exponent_std *
                     (known.log_gain_per_exponent.value_or(0.0) - 0.5 * light.log_distance2[i]);
  }
  if (!known.log_gain_per_exponent) return;
  slopes.topLeftCorner(kGain, static_cast<Eigen::Index>(blocks())).colwise() -= mean;
}

}  // namespace vildar
