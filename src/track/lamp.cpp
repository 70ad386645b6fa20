#include "track/lamp.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "optics/lamp_colour.h"

namespace vildar {
namespace {

// Prior speed along the road of a light just found, about that of a standing one.
constexpr double kSpeedSigma_mps = 18.0;
constexpr double kAcrossSpeedSigma_mps = 1.5;
// Nearer lights are mostly reflections, which would search half the image for a successor.
constexpr double kNearestPrior_per_m = 1.0 / 6.0;
constexpr double kUnknownSpeedSigma_pxps = 12.0;
constexpr double kAccelerationSigma_mps2 = 4.0;
// Camera shake that is left after the common image motion is taken out.
constexpr double kShake_px = 0.4;
constexpr double kShakeMoving_px = 0.8;
constexpr double kShake_pxps2 = 40.0;
// A camera that is held by hand turns all lamps more than that, look after look, as one that drives
// through a bend does: where squares of innovations have been so many times what they should be, so
// is the acceleration.
constexpr double kUsualStrain = 1.5, kMostStrain = 10.0;
// Flow vectors shorter than this say nothing about speed: the spot is at the vanishing point.
constexpr double kFlowFloor_px = 25.0;
constexpr double kMostDepthRate_per_s = 6.0;

}  // namespace

Lamp::Lamp(const Spot& spot, const LampPlace& place, std::int64_t frame, CameraTime time,
           const RoadView& view)
    : at_px_(spot.at_px),
      state_s_(seconds_of(time)),
      place_(place),
      least_px_(spot.at_px),
      most_px_(spot.at_px),
      first_time_(time) {
  const double inverse_depth = std::min(place.inverse_depth_per_m, kNearestPrior_per_m);
  const double likely_inverse_depth =
      std::min(inverse_depth + view.inverse_depth_sigma_per_m(place), kNearestPrior_per_m);
  velocity_pxps_ = view.turning_pxps(at_px_, state_s_);
  // From a moving sensor everything nears at its speed, but what it follows.
  if (view.moving_sensor() && spot.blob->kind != LampKind::taillamp)
    velocity_pxps_ += view.ego_speed_mps(seconds_of(time)) * inverse_depth * place.toward_px;
  const Eigen::Vector2d along = kSpeedSigma_mps * likely_inverse_depth * place.toward_px;
  const double spread_pxps = std::hypot(
      kUnknownSpeedSigma_pxps, kAcrossSpeedSigma_mps * likely_inverse_depth * view.focal_px());
  covariance_.setZero();
  covariance_.topLeftCorner<2, 2>() = Eigen::Matrix2d::Identity() * spot.sigma_px * spot.sigma_px;
  covariance_.bottomRightCorner<2, 2>() =
      along * along.transpose() + Eigen::Matrix2d::Identity() * spread_pxps * spread_pxps;
  log_flux_ = std::log(std::max(spot.blob->flux, 1e-9));
  remember(spot, Eigen::Vector2d::Zero(), frame, time);
}

void Lamp::predict(double dt_s, const RoadView& view, bool turns) {
  place_ = view.place(at_px_);
  const Eigen::Vector2d& flow_px = place_.toward_px;
  // How the sensor turns moves far lights and near ones alike: it tells no depth.
  const Eigen::Vector2d turning_pxps = view.turning_pxps(at_px_, state_s_);
  // Nor does the sensor's own drive, where the road under the lamp takes another direction.
  const double own_per_s = view.ego_speed_mps(state_s_) * place_.inverse_depth_per_m;
  const Eigen::Vector2d aside_pxps = own_per_s * (place_.sensor_ahead_px - flow_px);
  const Eigen::Vector2d nearing_pxps = velocity_pxps_ - turning_pxps;
  const double per_second = (nearing_pxps - aside_pxps).dot(flow_px) /
                            (flow_px.squaredNorm() + kFlowFloor_px * kFlowFloor_px);
  depth_rate_per_s_ = std::clamp((per_second - own_per_s) * place_.depth_per_toward +
                                     own_per_s * place_.depth_per_sensor_ahead,
                                 -kMostDepthRate_per_s, kMostDepthRate_per_s);
  state_s_ += dt_s;
  // A point at constant speed on a straight line moves in the image as t / (1 + rate t).
  const double looming = 1.0 / std::max(0.4, 1.0 + depth_rate_per_s_ * dt_s);
  at_px_ += (nearing_pxps * looming + turning_pxps) * dt_s;
  velocity_pxps_ = nearing_pxps * looming * looming + view.turning_pxps(at_px_, state_s_);

  Eigen::Matrix4d transition = Eigen::Matrix4d::Identity();
  transition.topRightCorner<2, 2>() = Eigen::Matrix2d::Identity() * dt_s * looming;
  transition.bottomRightCorner<2, 2>() *= looming * looming;
  covariance_ = transition * covariance_ * transition.transpose();
  const double acceleration_pxps2 =
      (turns ? std::clamp(strain_ / kUsualStrain, 1.0, kMostStrain) : 1.0) *
      std::hypot(kShake_pxps2,
                 kAccelerationSigma_mps2 * place_.inverse_depth_per_m * view.focal_px());
  const double shake_px = view.moving_sensor() ? kShakeMoving_px : kShake_px;
  const double q = acceleration_pxps2 * acceleration_pxps2 * dt_s * dt_s;
  for (int axis = 0; axis < 2; ++axis) {
    covariance_(axis, axis) += 0.25 * q * dt_s * dt_s + shake_px * shake_px;
    covariance_(axis, axis + 2) += 0.5 * q * dt_s;
    covariance_(axis + 2, axis) += 0.5 * q * dt_s;
    covariance_(axis + 2, axis + 2) += q;
  }
}

void Lamp::shift(const Eigen::Vector2d& shift_px, double dt_s) {
  constexpr double kShareInVelocity = 0.15;
  at_px_ += shift_px;
  drift_px_ += shift_px;
  velocity_pxps_ += kShareInVelocity / dt_s * shift_px;
}

std::optional<Lamp::Distance> Lamp::distance_within(const Spot& spot, double gate_chi2) const {
  Eigen::Matrix2d covariance = covariance_.topLeftCorner<2, 2>();
  covariance.diagonal().array() += spot.sigma_px * spot.sigma_px;
  const Eigen::Vector2d miss_px = spot.at_px - at_px_;
  // No variance is greater than their sum: most spots of a crowd are told to be too far by it.
  if (miss_px.squaredNorm() > gate_chi2 * covariance.trace()) return std::nullopt;
  const double chi2 = miss_px.dot(covariance.inverse() * miss_px);
  if (!(chi2 < gate_chi2)) return std::nullopt;
  return Distance{chi2, std::log(covariance.determinant())};
}

void Lamp::correct(const Eigen::Vector2d& measured_px, double sigma_px) {
  Eigen::Matrix2d innovation = covariance_.topLeftCorner<2, 2>();
  innovation.diagonal().array() += sigma_px * sigma_px;
  const Eigen::Matrix2d precision = innovation.inverse();
  const Eigen::Vector2d miss_px = measured_px - at_px_;
  constexpr double kNewest = 0.3;
  strain_ += kNewest * (0.5 * miss_px.dot(precision * miss_px) - strain_);
  const Eigen::Matrix<double, 4, 2> gain = covariance_.leftCols<2>() * precision;
  const Eigen::Vector4d step = gain * miss_px;
  at_px_ += step.head<2>();
  velocity_pxps_ += step.tail<2>();
  covariance_ -= gain * covariance_.topRows<2>();
  covariance_ = (0.5 * (covariance_ + covariance_.transpose())).eval();
}

void Lamp::update(const Spot& spot, std::int64_t frame, CameraTime time) {
  correct(spot.at_px, spot.sigma_px);
  remember(spot, Eigen::Vector2d::Zero(), frame, time);
}

void Lamp::update_merged(const Spot& spot, const Eigen::Vector2d& off_px, std::int64_t frame,
                         CameraTime time) {
  constexpr double kLooser = 2.0;  // the share of each lamp in the blob is not known
  correct(spot.at_px + off_px, kLooser * spot.sigma_px);
  remember(spot, off_px, frame, time);
}

void Lamp::carry(const Eigen::Vector2d& moved_px, const Eigen::Vector2d& speed_change_pxps) {
  at_px_ += moved_px;
  velocity_pxps_ += speed_change_pxps;
}

void Lamp::start_anew(CameraTime time, int paired) {
  records.clear();
  set_aside.clear();
  paired_sightings += std::min(paired, sightings_);
  head_votes_ = tail_votes_ = unsure_votes_ = sightings_ = 0;
  red = lamp_like = RunningShare{};
  first_time_ = last_time_ = time;
  least_px_ = most_px_ = at_px_ - drift_px_;
  vehicle = nullptr;
}

void Lamp::set_aside_before(CameraTime time) {
  const auto keep_from =
      std::ranges::find_if(records, [&](const auto& one) { return one.time >= time; });
  if (keep_from - records.begin() > std::ssize(set_aside))
    set_aside.assign(records.begin(), keep_from);
  records.erase(records.begin(), keep_from);
}

Lamp Lamp::before_doubt() const {
  Lamp earlier = *this;
  earlier.records = set_aside;
  earlier.set_aside.clear();
  earlier.doubtful_at.reset();
  if (set_aside.empty()) return earlier;
  earlier.at_px_ = set_aside.back().at_px;
  earlier.first_time_ = set_aside.front().time;
  earlier.last_time_ = set_aside.back().time;
  earlier.last_frame_ = set_aside.back().frame;
  return earlier;
}

void Lamp::leave_to_pair(std::vector<LampRecord>::const_iterator first) {
  set_aside.clear();
  paired_sightings += static_cast<int>(first - records.cbegin());
  records.erase(records.cbegin(), first);
  sightings_ = static_cast<int>(records.size());
  if (!records.empty()) first_time_ = records.front().time;
}

void Lamp::remember(const Spot& spot, const Eigen::Vector2d& off_px, std::int64_t frame,
                    CameraTime time) {
  constexpr double kFluxMemory = 0.3;
  constexpr int kColourMemory = 6, kLampMemory = 20;
  const Blob& blob = *spot.blob;
  log_flux_ += kFluxMemory * (std::log(std::max(blob.flux, 1e-9)) - log_flux_);
  const bool tells = colour_tells(blob.cr, blob.cb, blob.colour_chance);
  const bool unsure = !tells && opposed(kind(), blob.kind);
  unsure_votes_ += unsure;
  head_votes_ += !unsure && blob.kind == LampKind::headlamp;
  tail_votes_ += !unsure && blob.kind == LampKind::taillamp;
  const double tail_log_odds = tail_lamp_log_odds(blob.cr, blob.cb);
  red.add(tail_log_odds > 0.0, kColourMemory);
  lamp_like.add(blob.kind != LampKind::other, kLampMemory);
  ++sightings_;
  last_frame_ = frame;
  last_time_ = time;
  const Eigen::Vector2d steady_px = spot.at_px + off_px - drift_px_;
  least_px_ = least_px_.cwiseMin(steady_px);
  most_px_ = most_px_.cwiseMax(steady_px);
  const Defect defects = spot.with_streak ? blob.defects | Defect::merged : blob.defects;
  records.push_back(
      {frame, time,
       LampSighting{spot.centre_px, spot.centre_sigma_px, blob.flux, blob.flux_sigma,
                    blob.saturated_px, blob.box, blob.row_fraction, defects, blob.lamp},
       spot.at_px, tail_log_odds, faint_tail_lamp_log_odds(blob.cr, blob.cb, blob.colour_chance),
       off_px.norm(), 0.0, spot.streak, spot.casts_image});
}

LampKind Lamp::kind() const {
  const int votes = head_votes_ + tail_votes_;
  if (2 * votes < sightings_ - unsure_votes_) return LampKind::other;
  if (head_votes_ >= 2 * tail_votes_) return LampKind::headlamp;
  if (tail_votes_ >= 2 * head_votes_) return LampKind::taillamp;
  return LampKind::other;
}

double Lamp::position_sigma_px() const {
  return std::sqrt(0.5 * covariance_.topLeftCorner<2, 2>().trace());
}

double Lamp::velocity_sigma_pxps() const {
  return std::sqrt(0.5 * covariance_.bottomRightCorner<2, 2>().trace());
}

double Lamp::unseen_s(CameraTime now) const { return seconds_of(now) - seconds_of(last_time_); }
double Lamp::lived_s() const { return seconds_of(last_time_) - seconds_of(first_time_); }

}  // namespace vildar
