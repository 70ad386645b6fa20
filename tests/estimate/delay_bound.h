#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>

#include "simulated_beam.h"

namespace vildar::simulated {

/// What is known beforehand of a vehicle before two photodiodes, of unknown lamps.
struct DelayKnowledge {
  double baseline_m = 2.0, baseline_std_m = 0.0;
  double gain_std = 0.0;                ///< of ln (far gain over near gain)
  double angular_std = 0.0;             ///< of Receiving::angular_gain; 0: alike
  double acceleration_std_mps2 = 1.5;   ///< at the first sample
  double wander_mps2_per_root_s = 0.0;  ///< of the acceleration from there on; 0: constant
};

/// Cramer-Rao bound (Bayesian in what has a prior) of the relative speed from both photodiodes'
/// samples from 0 s to 8 s: a dense Fisher information of the samples by the law of the simulator,
/// its light over the distance ahead being a free cubic spline of `pieces` parts. Shares no code
/// with the estimator.
class DelayBound {
 public:
  DelayBound(const Vehicle& vehicle, const Site& site, const Beam& beam, const Receiving& receiving,
             const DelayKnowledge& known, int pieces = 64)
      : vehicle_(vehicle), known_(known), pieces_(pieces) {
    const double last_s = end_s(0.0);
    for (int k = 1; known.wander_mps2_per_root_s > 0.0 && k <= kSteps; ++k)
      steps_s_.push_back(last_s * k / (kSteps + 1));
    const Eigen::Index n = first_step() + static_cast<Eigen::Index>(steps_s_.size());
    information_ = Eigen::MatrixXd::Zero(n, n);
    for (const bool far : {false, true}) add_samples(site, beam, receiving, far);
    add_priors();
    const Eigen::VectorXd scale = information_.diagonal().cwiseSqrt().cwiseInverse();
    const Eigen::LDLT<Eigen::MatrixXd> solver(scale.asDiagonal() * information_ *
                                              scale.asDiagonal());
    covariance_ =
        scale.asDiagonal() * solver.solve(Eigen::MatrixXd::Identity(n, n)) * scale.asDiagonal();
  }

  /// Standard deviation of the speed at this time over that speed.
  double relative_speed(double time_s) const {
    Eigen::VectorXd slopes = Eigen::VectorXd::Zero(covariance_.rows());
    slopes[kLogSpeed] = vehicle_.speed_mps;
    slopes[kAcceleration] = time_s;
    for (std::size_t k = 0; k < steps_s_.size(); ++k)
      slopes[first_step() + static_cast<Eigen::Index>(k)] = std::max(0.0, time_s - steps_s_[k]);
    return std::hypot(std::sqrt(slopes.dot(covariance_ * slopes)) / vehicle_.speed_at_mps(time_s),
                      known_.baseline_std_m / known_.baseline_m);
  }

 private:
  enum Unknown : Eigen::Index {
    kLogSpeed,  // at t = 0
    kAcceleration,
    kLogGain,
    kAngular,
    kAmbient,
    kFarAmbient,
    kCurve
  };
  static constexpr int kSteps = 24;
  static constexpr double kNearest_m = 3.0;  // about where the pieces are shortest

  Eigen::Index first_step() const { return kCurve + pieces_ + 3; }
  double end_s(double receiver_m) const {
    double t_s = 0.0;
    while (vehicle_.along_at_m(t_s) - receiver_m > -4.0 && t_s < 8.0) t_s += 1e-3;
    return t_s;
  }

  // The four splines of equal pieces over asinh of the distance ahead that are not zero there.
  std::array<double, 4> splines(double ahead_m, Eigen::Index& first) const {
    const double from = std::asinh(-9.0 / kNearest_m), to = std::asinh(62.0 / kNearest_m);
    const double place = (std::asinh(ahead_m / kNearest_m) - from) / (to - from) * pieces_;
    const double piece = std::clamp(std::floor(place), 0.0, pieces_ - 1.0);
    const double u = place - piece, v = 1.0 - u;
    first = kCurve + static_cast<Eigen::Index>(piece);
    return {v * v * v / 6.0, (3.0 * u * u * u - 6.0 * u * u + 4.0) / 6.0,
            (3.0 * v * v * v - 6.0 * v * v + 4.0) / 6.0, u * u * u / 6.0};
  }

  void add_samples(const Site& site, const Beam& beam, const Receiving& receiving, bool far) {
    const auto& place = site.photodiodes[far ? 1 : 0].position_m;
    const Eigen::Vector3d receiver_m(place[0].mean, place[1].mean, place[2].mean);
    const double first = beam_power(vehicle_, site.road, beam, receiver_m, 0.0);
    if (!far) unit_ = first;
    const double sigma = first * std::pow(10.0, -receiving.snr_db / 20.0);
    const auto light = [&](double ahead_m) {
      Vehicle there = vehicle_;
      there.along_m = ahead_m + receiver_m.x();
      return beam_power(there, site.road, beam, receiver_m, 0.0) / sigma;
    };
    std::vector<std::pair<Eigen::Index, double>> slopes;
    for (double t_s = 0.0; vehicle_.along_at_m(t_s) > receiving.until_m && t_s < 8.0; t_s += 1e-3) {
      const double ahead_m = vehicle_.along_at_m(t_s) - receiver_m.x();
      constexpr double kStep_m = 1e-3;
      const double here = light(ahead_m);
      const double per_m = (light(ahead_m + kStep_m) - light(ahead_m - kStep_m)) / (2.0 * kStep_m);
      slopes.clear();
      slopes.emplace_back(kLogSpeed, -per_m * vehicle_.speed_mps * t_s);
      slopes.emplace_back(kAcceleration, -0.5 * per_m * t_s * t_s);
      for (std::size_t k = 0; k < steps_s_.size(); ++k)
        if (const double since_s = t_s - steps_s_[k]; since_s > 0.0)
          slopes.emplace_back(first_step() + static_cast<Eigen::Index>(k),
                              -0.5 * per_m * since_s * since_s);
      if (far) {
        const double off_axis_rad = std::atan2(
            std::hypot(vehicle_.lateral_m - receiver_m.y(), vehicle_.height_m - receiver_m.z()),
            std::max(0.01, ahead_m));
        slopes.emplace_back(kLogGain, here);
        slopes.emplace_back(kAngular, here * off_axis_rad / 0.35);
      }
      slopes.emplace_back(far ? kFarAmbient : kAmbient, 1.0);
      Eigen::Index curve = 0;
      const std::array<double, 4> splines_here = splines(ahead_m, curve);
      for (Eigen::Index k = 0; k < 4; ++k)
        slopes.emplace_back(curve + k, splines_here[static_cast<std::size_t>(k)] * unit_ / sigma);
      for (const auto& [i, one] : slopes)
        for (const auto& [j, other] : slopes) information_(i, j) += one * other;
    }
    constexpr double kAmbientStd = 0.05;  // of a sample's noise, as the trace states it
    const Eigen::Index level = far ? kFarAmbient : kAmbient;
    information_(level, level) += 1.0 / (kAmbientStd * kAmbientStd);
  }

  void add_priors() {
    constexpr double kKnown = 1e-9;
    const auto add = [&](Eigen::Index unknown, double std) {
      information_(unknown, unknown) += 1.0 / std::pow(std::max(std, kKnown), 2);
    };
    add(kAcceleration, known_.acceleration_std_mps2);
    add(kLogGain, known_.gain_std);
    add(kAngular, known_.angular_std);
    for (std::size_t k = 0; k < steps_s_.size(); ++k)
      add(first_step() + static_cast<Eigen::Index>(k),
          known_.wander_mps2_per_root_s * std::sqrt(steps_s_.front()));
    for (Eigen::Index k = kCurve; k < first_step(); ++k) add(k, 1e6);
  }

  Vehicle vehicle_;
  DelayKnowledge known_;
  int pieces_;
  double unit_ = 1.0;  // of the curve: the near light of the first sample
  std::vector<double> steps_s_;
  Eigen::MatrixXd information_, covariance_;
};

}  // namespace vildar::simulated
