#include "optics/ego_motion.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include "core/median.h"
#include "core/quantity.h"
#include "core/robust_line.h"
#include "optics/road.h"

namespace vildar {
namespace {

// One who keeps to the lane heads to and fro by so much, for so long each way.
constexpr double kLaneKeeping_rad = 0.008, kToAndFro_s = 4.0, kLanePlace_m = 0.25;
constexpr double kNearest_m = 1.0;
// Where yaw rates are told: the first of the swings that are those of one ahead, after the rates'
// relative error and bias.
constexpr std::size_t kSways = 5;
// Clocks of other devices, and what their gyroscopes are good to.
constexpr Uncertain kDelay_s{0.0, 0.1}, kTurns{0.0, 0.02};

// Legendre's polynomials of degree 0 to `kDegrees` - 1 at -1 <= x <= 1.
template <int kDegrees>
Eigen::Vector<double, kDegrees> legendre(double x) {
  Eigen::Vector<double, kDegrees> values;
  values[0] = 1.0;
  values[1] = x;
  for (int n = 1; n + 1 < kDegrees; ++n)
    values[n + 1] = ((2 * n + 1) * x * values[n] - n * values[n - 1]) / (n + 1);
  return values;
}

// -1 to 1 over the time in which it is watched, and the nearer of them outside.
double place_in(const TimeSpan& watched, double time_s) {
  return std::clamp(
      (2.0 * time_s - watched.from_s - watched.to_s) / (watched.to_s - watched.from_s), -1.0, 1.0);
}

}  // namespace

HeadingSwings::HeadingSwings(TimeSpan watched, double alike_s) : watched_(watched) {
  constexpr int kPoints = 48;
  const double half_s = 0.5 * (watched.to_s - watched.from_s);
  const auto place_of = [](int point) { return (2.0 * point + 1.0) / kPoints - 1.0; };
  Eigen::MatrixXd alike(kPoints, kPoints), polynomials(kPoints, kDegrees);
  for (int i = 0; i < kPoints; ++i) {
    polynomials.row(i) = legendre<kDegrees>(place_of(i));
    for (int j = 0; j < kPoints; ++j) {
      const double apart = half_s * (place_of(i) - place_of(j)) / alike_s;
      alike(i, j) = std::exp(-0.5 * apart * apart) / kPoints;
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(alike);
  const Eigen::MatrixXd largest = modes.eigenvectors().rowwise().reverse().leftCols<kOwnSwings>();
  variances_ = modes.eigenvalues().reverse().head<kOwnSwings>().array().max(0.0);
  curves_ = std::sqrt(kPoints) * polynomials.colPivHouseholderQr().solve(largest).transpose();
}

HeadingSwings::Values HeadingSwings::heading_at(double time_s) const {
  return (curves_ * legendre<kDegrees>(place_in(watched_, time_s))).array();
}

HeadingSwings::Values HeadingSwings::way_s(double time_s) const {
  const double inside_s = std::clamp(time_s, watched_.from_s, watched_.to_s);
  const auto at = legendre<kDegrees + 1>(place_in(watched_, time_s));
  Eigen::Vector<double, kDegrees> integral;
  integral[0] = at[1];
  for (int n = 1; n < kDegrees; ++n) integral[n] = (at[n + 1] - at[n - 1]) / (2 * n + 1);
  const double half_s = 0.5 * (watched_.to_s - watched_.from_s);
  return half_s * (curves_ * integral).array() + (time_s - inside_s) * heading_at(time_s);
}

HeadingSwings::Values HeadingSwings::way_s(double from_s, double to_s) const {
  return way_s(to_s) - way_s(from_s);
}

namespace {

// What the yaw rates of a trace add up to, from its first sample on.
struct ToldHeadings {
  std::vector<EgoSample> samples;
  std::vector<double> times_s, headings_rad;

  ToldHeadings(const EgoSite& site, const TimeSpan& time) {
    double heading_rad = 0.0;
    for (const EgoSample& sample : site.trace) {
      if (sample.time_s < time.from_s || sample.time_s > time.to_s) continue;
      if (!times_s.empty())
        heading_rad += (sample.time_s - times_s.back()) * sample.yaw_rate_rad_per_s;
      samples.push_back(sample);
      times_s.push_back(sample.time_s);
      headings_rad.push_back(heading_rad);
    }
  }
  std::size_t count() const { return times_s.size(); }
  /// How far to the left of a line on which it heads so.
  std::vector<double> ways_m(const std::vector<double>& off_rad) const {
    std::vector<double> ways_m{0.0};
    for (std::size_t i = 1; i < count(); ++i)
      ways_m.push_back(ways_m.back() +
                       (times_s[i] - times_s[i - 1]) * samples[i].speed_mps * off_rad[i]);
    return ways_m;
  }
  std::vector<double> off(const RobustLine& line) const {
    std::vector<double> off_rad;
    for (std::size_t i = 0; i < count(); ++i)
      off_rad.push_back(headings_rad[i] - line.at(times_s[i]));
    return off_rad;
  }
};

// A change of lanes that has begun ends.
TimeSpan with_what_goes_on(const TimeSpan& time) {
  constexpr double kBesides_s = 2.0;
  return {time.from_s - kBesides_s, time.to_s + kBesides_s};
}

// Whether the own vehicle's turns may be those of a road that is told to be straight: they go on to
// one side, or take it farther aside and back than a change of lanes. Beside one that drives ahead
// and keeps to its lane no better, gentle ones are no more than what it may do itself.
bool bends_with_the_road(const EgoSite& site, const Watched& watched) {
  constexpr double kGentle_rad = 0.02, kBend_rad = 0.03, kPerSwing = 2.0, kLanes_m = 5.0;
  const ToldHeadings told(site, with_what_goes_on(watched.time));
  if (told.count() < 3) return false;
  const RobustLine bend = least_deviations_line(told.times_s, told.headings_rad);
  const std::vector<double> off_rad = told.off(bend), aside_m = told.ways_m(off_rad);
  const auto [most_right_rad, most_left_rad] = std::ranges::minmax(off_rad);
  const auto [rightmost_m, leftmost_m] = std::ranges::minmax(aside_m);
  const double swing_rad = std::max(most_left_rad, -most_right_rad);
  const double turned_rad = std::abs(bend.slope) * (told.times_s.back() - told.times_s.front());
  return (watched.same_way && swing_rad < kGentle_rad) ||
         turned_rad > kBend_rad + kPerSwing * swing_rad || leftmost_m - rightmost_m > kLanes_m;
}

// Root mean square of the headings that yaw rates tell, about a line: what may be the road's or the
// own vehicle's.
double told_swing_rad(const EgoSite& site, const TimeSpan& time) {
  const ToldHeadings told(site, with_what_goes_on(time));
  if (!site.turns_known() || told.count() < 3) return 0.0;
  double squares = 0.0;
  for (const double off_rad : told.off(least_deviations_line(told.times_s, told.headings_rad)))
    squares += off_rad * off_rad;
  return std::sqrt(squares / static_cast<double>(told.count()));
}

}  // namespace

bool turns_told(const EgoSite& site, const RoadSite& road, const Watched& watched) {
  constexpr double kTimesNoise = 25.0;
  constexpr std::size_t kFewest = 12;
  // Of a random walk's integral over a time, about its line: the root mean square, over that of the
  // walk's end and the time.
  constexpr double kAboutLine = 0.0492;
  if (!site.turns_known() ||
      (road.kind == RoadKind::straight && bends_with_the_road(site, watched)))
    return false;
  const ToldHeadings told(site, watched.time);
  if (told.count() < kFewest) return true;
  const auto count = static_cast<double>(told.count());
  double speed_mps = 0.0;
  for (const EgoSample& sample : told.samples) speed_mps += sample.speed_mps / count;
  const double noise_rad_per_s = yaw_rate_noise_rad_per_s(told.samples);
  const double lasts_s = told.times_s.back() - told.times_s.front();
  const double step_s = lasts_s / (count - 1.0);
  const double noise_m =
      kAboutLine * speed_mps * noise_rad_per_s * std::sqrt(step_s * lasts_s) * lasts_s;
  const std::vector<double> way_m = told.ways_m(told.headings_rad);
  const RobustLine line = least_deviations_line(told.times_s, way_m);
  double squares_m2 = 0.0;
  for (std::size_t i = 0; i < told.count(); ++i)
    squares_m2 += std::pow(way_m[i] - line.at(told.times_s[i]), 2);
  return std::sqrt(squares_m2 / count) >= kTimesNoise * noise_m;
}

EgoMotion::EgoMotion(const EgoSite& site, const RoadSite& road, std::optional<Watched> watched)
    : site_(site),
      moving_(true),
      turns_known_(watched ? turns_told(site, road, *watched) : site.turns_known()) {
  if (road.radius_m) road_curvature_per_m_ = bend_of(road) / road.radius_m->mean;
  straight_m_ = road.straight_m.mean;
  if (turns_known_) curvature_per_m_ = road_curvature_per_m_;
  springs_sigma_mps2_ = springs_sigma_mps2();
  if (!watched) return;
  site_.trace = without_speed_noise(std::move(site_.trace), watched->time);
  constexpr int kPoints = 64;
  double sum = 0.0;
  for (int i = 0; i < kPoints; ++i)
    sum += std::pow(
        untold_mps(std::lerp(watched->time.from_s, watched->time.to_s, (i + 0.5) / kPoints)), 2);
  untold_mps_ = std::sqrt(sum / kPoints);
  if (turns_known_) {
    rate_errors_.emplace(site_, watched->time);
    if (!watched->same_way) return;
  }
  swings_.emplace(watched->time, kToAndFro_s / kPi);
  swing_rad_ = std::max(kLaneKeeping_rad, told_swing_rad(site, watched->time));
  same_way_ = watched->same_way;
}

double EgoMotion::interpolated(double time_s, double EgoSample::*field) const {
  const auto& trace = site_.trace;
  const auto above = std::lower_bound(
      trace.begin(), trace.end(), time_s,
      [](const EgoSample& sample, double wanted_s) { return sample.time_s < wanted_s; });
  if (above == trace.begin()) return trace.front().*field;
  if (above == trace.end()) return trace.back().*field;
  const EgoSample& below = *(above - 1);
  const double share = (time_s - below.time_s) / (above->time_s - below.time_s);
  return (1.0 - share) * (below.*field) + share * ((*above).*field);
}

// By how much the speed may be off what is taken for it between samples, or held beyond them:
// drivers change it by 1 m/s^2, and that over a second or two.
double EgoMotion::untold_mps(double time_s) const {
  constexpr double kChange_mps2 = 1.0, kSteady_s = 2.0;
  const auto& trace = site_.trace;
  if (trace.empty()) return 0.0;
  if (time_s < trace.front().time_s) return kChange_mps2 * (trace.front().time_s - time_s);
  const auto above = std::ranges::upper_bound(trace, time_s, {}, &EgoSample::time_s);
  if (above == trace.end()) return kChange_mps2 * (time_s - trace.back().time_s);
  const double since_s = time_s - (above - 1)->time_s, until_s = above->time_s - time_s;
  const double apart_s = since_s + until_s;
  return kChange_mps2 * std::min(1.0, apart_s / kSteady_s) * since_s * until_s / apart_s;
}

double EgoMotion::speed_mps(double time_s) const {
  if (!moving_) return 0.0;
  return site_.trace.empty() ? site_.speed_mps.mean : interpolated(time_s, &EgoSample::speed_mps);
}

double EgoMotion::turn_rate_rad_per_s(double time_s, double way_m) const {
  if (turns_known_) return interpolated(time_s, &EgoSample::yaw_rate_rad_per_s);
  return way_m < straight_m_ ? 0.0 : road_curvature_per_m_ * speed_mps(time_s);
}

template <class TurnRate>
DrivenPose EgoMotion::driven(DrivenPose pose, double to_s,
                             const TurnRate& turn_rate_rad_per_s) const {
  // Traces are given at 1 to 50 Hz; stamps may jump by years.
  constexpr double kStep_s = 0.02, kMostSteps = 1e5;
  const double from_s = pose.time_s, span_s = to_s - from_s;
  const double steps = std::clamp(std::ceil(std::abs(span_s) / kStep_s), 1.0, kMostSteps);
  const double step_s = span_s / steps;
  for (double step = 0.5; step < steps; ++step) {
    const double middle_s = from_s + step * step_s;
    const double length_m = speed_mps(middle_s) * step_s;
    const double turn_rad = turn_rate_rad_per_s(middle_s, pose.way_m) * step_s;
    const double middle_rad = pose.heading_rad + 0.5 * turn_rad;
    pose.x_m += length_m * std::cos(middle_rad);
    pose.y_m += length_m * std::sin(middle_rad);
    pose.heading_rad += turn_rad;
    pose.way_m += length_m;
  }
  pose.time_s = to_s;
  return pose;
}

DrivenPose EgoMotion::driven(const DrivenPose& from, double to_s) const {
  return driven(from, to_s,
                [this](double time_s, double way_m) { return turn_rate_rad_per_s(time_s, way_m); });
}

// The slope of the line through the speeds about then, as far as the trace tells them: stamps and
// speeds of a trace scatter.
double EgoMotion::springs_mps2(double time_s) const {
  constexpr double kLag_s = 0.2, kStep_s = 0.1;
  constexpr int kSteps = 5;  // either way
  std::vector<double> at_s, at_mps;
  for (int k = -kSteps; k <= kSteps; ++k) {
    const double one_s = time_s - kLag_s + k * kStep_s;
    if (one_s < site_.trace.front().time_s || one_s > site_.trace.back().time_s) continue;
    at_s.push_back(one_s);
    at_mps.push_back(speed_mps(one_s));
  }
  if (at_s.size() < 3) return 0.0;
  const auto n = static_cast<double>(at_s.size());
  const double mean_s = std::accumulate(at_s.begin(), at_s.end(), 0.0) / n;
  double product = 0.0, square = 0.0;
  for (std::size_t i = 0; i < at_s.size(); ++i) {
    product += (at_s[i] - mean_s) * at_mps[i];
    square += (at_s[i] - mean_s) * (at_s[i] - mean_s);
  }
  return product / square;
}

// Of that, for how the speeds of a trace scatter from sample to sample.
double EgoMotion::springs_sigma_mps2() const {
  constexpr double kOver_s = 1.0;
  const std::vector<EgoSample>& trace = site_.trace;
  if (trace.size() < 4) return 0.0;
  std::vector<double> bends_mps;
  for (std::size_t i = 2; i < trace.size(); ++i)
    bends_mps.push_back(trace[i].speed_mps - 2.0 * trace[i - 1].speed_mps + trace[i - 2].speed_mps);
  const double sigma_mps = robust_sigma(std::move(bends_mps)) / std::sqrt(6.0);
  const double samples = kOver_s * static_cast<double>(trace.size() - 1) /
                         std::max(trace.back().time_s - trace.front().time_s, 1e-3);
  return sigma_mps / kOver_s * std::sqrt(12.0 / std::max(samples, 6.0));
}

EgoDeviation EgoMotion::deviation(double reference_s, double time_s) const {
  EgoDeviation deviation;
  deviation.curvature_per_m = curvature_per_m_;
  if (!moving_) return deviation;
  if (!turns_known_) deviation.by_swing = swings_by(reference_s, time_s);
  if (site_.trace.empty()) {
    deviation.along_m = site_.speed_mps.mean * (time_s - reference_s);
    return deviation;
  }
  const auto turn_rate_at = [this](double at_s) {
    if (!turns_known_) return 0.0;
    return interpolated(at_s, &EgoSample::yaw_rate_rad_per_s) - curvature_per_m_ * speed_mps(at_s);
  };
  const DrivenPose pose = driven({.time_s = reference_s}, time_s,
                                 [&](double at_s, double) { return turn_rate_at(at_s); });
  deviation.springs_mps2 = springs_mps2(time_s);
  deviation.springs_sigma_mps2 = springs_sigma_mps2_;
  deviation.ahead_m = pose.x_m - speed_mps(reference_s) * (time_s - reference_s);
  deviation.left_m = pose.y_m;
  deviation.heading_rad = pose.heading_rad;
  deviation.along_m = pose.x_m;
  if (turns_known_) {
    const double road_rad = curvature_per_m_ * pose.way_m;
    deviation.way_m = pose.way_m;
    deviation.by_swing[0] = {pose.y_m + 0.5 * road_rad * pose.way_m, pose.heading_rad + road_rad};
    if (rate_errors_) {
      const YawRateErrors::Values then = rate_errors_->heading_at(reference_s);
      const YawRateErrors::Values turned = rate_errors_->heading_at(time_s) - then;
      const double since_s = time_s - reference_s;
      const YawRateErrors::Values way_s =
          rate_errors_->way_s(time_s) - rate_errors_->way_s(reference_s) - since_s * then;
      const double usual_mps = since_s != 0.0 ? pose.way_m / since_s : 0.0;
      for (int k = 0; k < YawRateErrors::kCount; ++k)
        deviation.by_swing[static_cast<std::size_t>(k) + 1] = {usual_mps * way_s[k], turned[k]};
      // The last of the walk's curves are nothing beside how one ahead sways.
      for (std::size_t k = kSways; same_way_ && k < kOwnSwings; ++k)
        deviation.by_swing[k] = {
            0.0, swings_->heading_at(time_s)[static_cast<Eigen::Index>(k - kSways)]};
    }
  }
  const double speed = speed_mps(time_s), rate_then = turn_rate_at(reference_s);
  deviation.by_delay = {
      speed_mps(reference_s) - speed * std::cos(pose.heading_rad) - rate_then * pose.y_m,
      rate_then * pose.x_m - speed * std::sin(pose.heading_rad), rate_then - turn_rate_at(time_s)};
  return deviation;
}

std::array<EgoDeviation::Swing, kOwnSwings> EgoMotion::swings_by(double reference_s,
                                                                 double time_s) const {
  std::array<EgoDeviation::Swing, kOwnSwings> swings{};
  if (!swings_) return swings;
  const HeadingSwings::Values heading = swings_->heading_at(time_s);
  const double speed = same_way_ ? 0.0 : speed_mps(reference_s);
  const HeadingSwings::Values aside_m = speed * swings_->way_s(reference_s, time_s);
  for (int k = 0; k < kOwnSwings; ++k)
    swings[static_cast<std::size_t>(k)] = {aside_m[k], heading[k]};
  return swings;
}

OwnWay EgoMotion::lane_keeping(double reference_s, double range_m) const {
  constexpr double kCreeping_mps = 5.0;  // slower, one does not turn as much
  constexpr double kTold_rad =
      8e-6;  // less moves no lamp by more than a hundredth of a pixel or two
  OwnWay own;
  if (!site_.trace.empty()) own.delay_s = kDelay_s;
  if (!swings_) return own;
  const double share = std::min(1.0, speed_mps(reference_s) / kCreeping_mps);
  own.aside_std_m = kLanePlace_m * share;
  const double swaying_rad =
      same_way_ ? std::sqrt(2.0) * kLanePlace_m / std::max(range_m, kNearest_m) : 0.0;
  const double swing_rad = share * std::hypot(swing_rad_, swaying_rad);
  for (int k = 0; k < kOwnSwings; ++k) {
    const double std_rad = swing_rad * std::sqrt(swings_->variances()[k]);
    if (std_rad > kTold_rad) own.swings[static_cast<std::size_t>(k)].std = std_rad;
  }
  return own;
}

std::array<Uncertain, kOwnSwings> EgoMotion::errors_of_rates(double range_m) const {
  static_assert(kOwnSwings == 1 + YawRateErrors::kCount);
  std::array<Uncertain, kOwnSwings> errors{kTurns};
  if (rate_errors_) std::ranges::copy(rate_errors_->errors(), errors.begin() + 1);
  for (std::size_t k = kSways; same_way_ && k < kOwnSwings; ++k)
    errors[k] = {0.0, kLanePlace_m / std::max(range_m, kNearest_m) *
                          std::sqrt(swings_->variances()[static_cast<Eigen::Index>(k - kSways)])};
  return errors;
}

OwnWay EgoMotion::own_way(double reference_s, double range_m) const {
  constexpr double kReach_s = 8.0, kStep_s = 0.05;
  constexpr double kUnsure = 0.2;  // of the largest swing off the road
  constexpr double kMostOff_rad = 0.15;
  if (!turns_known_) return lane_keeping(reference_s, range_m);
  const OwnWay untold{{0.0, kLaneKeeping_rad}, kDelay_s, errors_of_rates(range_m), 0.0};
  if (!covers(reference_s, reference_s)) return untold;
  const double from_s = std::max(reference_s - kReach_s, site_.trace.front().time_s);
  const double to_s = std::min(reference_s + kReach_s, site_.trace.back().time_s);
  const auto steps = static_cast<int>((to_s - from_s) / kStep_s);
  if (steps < 2) return untold;
  std::vector<double> after_s, heading_rad;
  double turned_rad = 0.0, at_reference_rad = 0.0;
  std::ptrdiff_t at_reference = 0;
  for (int i = 0; i < steps; ++i) {
    const double middle_s = from_s + (i + 0.5) * kStep_s;
    turned_rad += kStep_s * (interpolated(middle_s, &EgoSample::yaw_rate_rad_per_s) -
                             curvature_per_m_ * speed_mps(middle_s));
    after_s.push_back(middle_s + 0.5 * kStep_s - reference_s);
    heading_rad.push_back(turned_rad);
    if (after_s.back() > 0.5 * kStep_s) continue;
    at_reference = i;
    at_reference_rad = turned_rad;
  }
  // One who turns by more leaves the road.
  const auto on_road = [&](double rad) { return std::abs(rad - at_reference_rad) < kMostOff_rad; };
  const auto reference = heading_rad.begin() + at_reference;
  const auto left = std::find_if_not(reference, heading_rad.end(), on_road);
  const auto joined =
      std::find_if_not(std::make_reverse_iterator(reference), heading_rad.rend(), on_road).base();
  const std::span<const double> headings_rad(joined, left);
  const auto times_s = std::span<const double>(after_s).subspan(
      static_cast<std::size_t>(joined - heading_rad.begin()), headings_rad.size());
  if (times_s.size() < 2) return untold;
  const RobustLine road = least_deviations_line(times_s, headings_rad);
  double swing_rad = 0.0, aside_m = 0.0, rightmost_m = 0.0, leftmost_m = 0.0;
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    const double off_rad = headings_rad[i] - road.at(times_s[i]);
    swing_rad = std::max(swing_rad, std::abs(off_rad));
    aside_m += kStep_s * speed_mps(reference_s + times_s[i]) * off_rad;
    rightmost_m = std::min(rightmost_m, aside_m);
    leftmost_m = std::max(leftmost_m, aside_m);
  }
  // A line's variance where it is read, over that of its mean: its points are even in time.
  const double seen_s = times_s.back() - times_s.front();
  const double off_middle = 0.5 * (times_s.back() + times_s.front()) / seen_s;
  const double keeping_rad = kLaneKeeping_rad * std::sqrt((1.0 + 12.0 * off_middle * off_middle) /
                                                          (1.0 + seen_s / kToAndFro_s));
  return {{at_reference_rad - road.at_zero, std::hypot(kUnsure * swing_rad, keeping_rad)},
          kDelay_s,
          errors_of_rates(range_m),
          0.5 * (leftmost_m - rightmost_m)};
}

bool EgoMotion::covers(double from_s, double to_s) const {
  if (site_.trace.empty()) return true;
  return site_.trace.front().time_s <= from_s && to_s <= site_.trace.back().time_s;
}

}  // namespace vildar
