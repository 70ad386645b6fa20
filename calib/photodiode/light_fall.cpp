#include "calib/photodiode/light_fall.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/QR>

#include "estimate/power_blocks.h"

namespace vildar {
namespace {

constexpr double kAround_s = 0.030;    // of the light that is fitted, before and after the falls
constexpr double kFewestAround = 6.0;  // samples there
constexpr double kShortestBlock_s = 5e-4;  // of a trace that is sampled more often
constexpr double kFinestStep_s = 1e-3;
constexpr double kApart_s = 0.020;
constexpr double kLikelyFall_s = 4e-3;  // of a lamp of a hand's breadth
constexpr double kLongestFall_s = 0.030;
constexpr double kClearSigmas = 10.0;

struct Sample {
  double time_s = 0.0, power_w = 0.0;
};

// Those of a trace between two times; of one that is sampled often, means.
std::vector<Sample> samples_of(const PowerTrace& trace, double from_s, double to_s) {
  std::vector<Sample> samples;
  if (trace.sample_period_s < kShortestBlock_s) {
    for (const PowerBlock& block : block_means(trace, from_s, to_s, kShortestBlock_s, 0.0))
      samples.push_back({block.time_s, block.power_w});
    return samples;
  }
  const auto first = std::lower_bound(trace.time_s.begin(), trace.time_s.end(), from_s);
  for (auto at = first; at != trace.time_s.end() && *at < to_s; ++at)
    samples.push_back({*at, trace.power_w[static_cast<std::size_t>(at - trace.time_s.begin())]});
  return samples;
}

struct Fit {
  double squares_w2 = 0.0;  // of what is left
  int degrees = 0;
  double fall_w = 0.0;
};

// How the light about a fall is fitted: of each lamp it takes so long to go, and grew before.
struct Form {
  double fall_s = 0.0, growth_per_s = 0.0;
};

class Falls {
 public:
  Falls(const PowerTrace& trace, const ExpectedFall& expected, double reach_s)
      : expected_(expected),
        first_s_(expected.lamps.front().time_s),
        last_s_(expected.lamps.back().time_s),
        period_s_(std::max(trace.sample_period_s, kShortestBlock_s)),
        around_s_(std::max(kAround_s, kFewestAround * period_s_)),
        samples_(samples_of(trace, first_s_ - reach_s - around_s_, last_s_ + reach_s + around_s_)),
        noise_w_(trace.noise_sigma_w *
                 std::sqrt(std::min(1.0, trace.sample_period_s / period_s_))) {}

  double period_s() const { return period_s_; }
  // Between these the trace has what lies about the falls.
  double earliest_s() const {
    return samples_.empty() ? INFINITY : samples_.front().time_s - first_s_ + around_s_;
  }
  double latest_s() const {
    return samples_.empty() ? -INFINITY : samples_.back().time_s - last_s_ - around_s_;
  }

  // At a glance: less light after the last lamp went than before the first did, beyond noise.
  bool may_fall(double late_s) {
    constexpr double kSigmas = 5.0;
    constexpr Eigen::Index kLooks = 4;
    if (!look_at(late_s)) return false;
    Eigen::Index before = 0, after = count_;
    while (before < count_ && after_first_s(before, late_s) < 0.0) ++before;
    while (after > 0 && sample(after - 1).time_s - late_s > last_s_) --after;
    if (before < kLooks || after + kLooks > count_) return false;
    double change_w = 0.0;
    for (Eigen::Index i = 1; i <= kLooks; ++i)
      change_w += (sample(before - i).power_w - sample(after + i - 1).power_w) / kLooks;
    return change_w > kSigmas * noise_w_ * std::sqrt(2.0 / kLooks);
  }

  // Light that goes, above a line; nothing where the trace lacks part of it.
  std::optional<Fit> fit(double late_s, const Form& form) {
    if (!look_at(late_s)) return std::nullopt;
    Eigen::MatrixXd terms(count_, 3);
    for (Eigen::Index i = 0; i < count_; ++i) {
      const double t_s = after_first_s(i, late_s);
      double left = 0.0;
      for (const LampFall& lamp : expected_.lamps) {
        const double after_s = t_s - (lamp.time_s - first_s_);
        left += lamp.share * std::exp(form.growth_per_s * after_s) *
                std::clamp(0.5 - after_s / form.fall_s, 0.0, 1.0);
      }
      terms.row(i) << 1.0, t_s / around_s_, left;
    }
    Eigen::VectorXd found;
    Fit fit = solved(terms, found);
    fit.fall_w = found[2];
    return fit;
  }

  // Light that does not fall.
  std::optional<Fit> smooth_fit(double late_s) {
    if (!look_at(late_s)) return std::nullopt;
    Eigen::MatrixXd terms(count_, 4);
    for (Eigen::Index i = 0; i < count_; ++i) {
      const double t = after_first_s(i, late_s) / around_s_;
      terms.row(i) << 1.0, t, t * t, t * t * t;
    }
    Eigen::VectorXd found;
    return solved(terms, found);
  }

  double variance_w2(const Fit& fit) const {
    return std::max(noise_w_ * noise_w_, fit.squares_w2 / std::max(1, fit.degrees));
  }

 private:
  const Sample& sample(Eigen::Index i) const {
    return samples_[first_ + static_cast<std::size_t>(i)];
  }
  double after_first_s(Eigen::Index i, double late_s) const {
    return sample(i).time_s - late_s - first_s_;
  }

  // Takes what lies about the falls; whether little of it is missing.
  bool look_at(double late_s) {
    constexpr double kMostMissing = 0.1;
    const double from_s = first_s_ + late_s - around_s_;
    const double to_s = last_s_ + late_s + around_s_;
    const auto by_time = [](const Sample& one, double time_s) { return one.time_s < time_s; };
    const auto first = std::lower_bound(samples_.begin(), samples_.end(), from_s, by_time);
    const auto last = std::lower_bound(first, samples_.end(), to_s, by_time);
    first_ = static_cast<std::size_t>(first - samples_.begin());
    count_ = last - first;
    return static_cast<double>(count_ + 1) > (1.0 - kMostMissing) * (to_s - from_s) / period_s_;
  }

  Fit solved(const Eigen::MatrixXd& terms, Eigen::VectorXd& found) const {
    Eigen::VectorXd light_w(count_);
    for (Eigen::Index i = 0; i < count_; ++i) light_w[i] = sample(i).power_w;
    found = terms.colPivHouseholderQr().solve(light_w);
    return {(terms * found - light_w).squaredNorm(), static_cast<int>(count_ - terms.cols()), 0.0};
  }

  const ExpectedFall& expected_;
  double first_s_, last_s_, period_s_, around_s_;
  std::vector<Sample> samples_;
  double noise_w_;
  std::size_t first_ = 0;  // of the samples looked at
  Eigen::Index count_ = 0;
};

// How clearly the light falls there; zero where it does not.
double sigmas_of(Falls& falls, double late_s, double fall_s, double turn_rad_per_s) {
  if (!falls.may_fall(late_s)) return 0.0;
  const auto smooth = falls.smooth_fit(late_s);
  double most = 0.0;
  for (const double growth_per_rad : {-9.0, -6.0, -3.0, 0.0}) {
    const auto fit = falls.fit(late_s, {fall_s, growth_per_rad * turn_rad_per_s});
    if (!smooth || !fit || !(fit->fall_w > 0.0)) continue;
    most = std::max(most, (smooth->squares_w2 - fit->squares_w2) / falls.variance_w2(*fit));
  }
  return std::sqrt(most);
}

// The best of all forms, for lamps have a size and beams differ; nothing where the trace lacks part
// of the light.
std::optional<Fit> best_fit(Falls& falls, double late_s, double turn_rad_per_s) {
  constexpr double kLonger = 1.5;
  std::optional<Fit> best;
  for (double fall_s = falls.period_s(); fall_s <= std::max(falls.period_s(), kLongestFall_s);
       fall_s *= kLonger)
    for (double growth_per_rad = -12.0; growth_per_rad <= 2.0; growth_per_rad += 1.0) {
      const auto fit = falls.fit(late_s, {fall_s, growth_per_rad * turn_rad_per_s});
      if (fit && (!best || fit->squares_w2 < best->squares_w2)) best = fit;
    }
  return best;
}

// The likeliest of the moments within `reach` steps of one; nothing where it is at their end, for
// then it is of another fall.
std::optional<double> likeliest_s(Falls& falls, double late_s, double step_s, int reach,
                                  double turn_rad_per_s) {
  int best = reach;
  double least_w2 = INFINITY;
  for (int k = -reach; k <= reach; ++k) {
    const auto fit = best_fit(falls, late_s + k * step_s, turn_rad_per_s);
    if (!fit || !(fit->squares_w2 < least_w2)) continue;
    least_w2 = fit->squares_w2;
    best = k;
  }
  if (std::abs(best) == reach) return std::nullopt;
  return late_s + best * step_s;
}

// With all forms open.
std::optional<LightFall> refined(Falls& falls, LightFall fall, double turn_rad_per_s) {
  constexpr double kReach_s = 0.005;
  constexpr int kFiner = 8;
  const double period_s = falls.period_s();
  const auto about_s =
      likeliest_s(falls, fall.late_s, period_s,
                  std::max(2, static_cast<int>(std::lround(kReach_s / period_s))), turn_rad_per_s);
  const auto late_s =
      about_s ? likeliest_s(falls, *about_s, period_s / kFiner, kFiner + 1, turn_rad_per_s)
              : std::nullopt;
  if (!late_s) return std::nullopt;
  fall.late_s = *late_s;
  const auto at = best_fit(falls, fall.late_s, turn_rad_per_s);
  const auto early = best_fit(falls, fall.late_s - period_s, turn_rad_per_s);
  const auto late = best_fit(falls, fall.late_s + period_s, turn_rad_per_s);
  if (!at || !early || !late) return std::nullopt;
  const double curvature =
      (early->squares_w2 + late->squares_w2 - 2.0 * at->squares_w2) / (period_s * period_s);
  if (!(curvature > 0.0)) return std::nullopt;
  // When within a sample the light went, no sample tells.
  fall.std_s =
      std::hypot(std::sqrt(2.0 * falls.variance_w2(*at) / curvature), period_s / std::sqrt(12.0));
  return fall;
}

}  // namespace

std::vector<LightFall> light_falls(const PowerTrace& trace, const ExpectedFall& expected,
                                   double reach_s) {
  Falls falls(trace, expected, reach_s);
  const double step_s = std::max(kFinestStep_s, falls.period_s());
  const double fall_s = std::max(step_s, kLikelyFall_s);
  std::vector<LightFall> clear;  // in order of time
  for (double steps = std::ceil(std::max(-reach_s, falls.earliest_s()) / step_s);
       steps * step_s <= std::min(reach_s, falls.latest_s()); steps += 1.0) {
    const double sigmas = sigmas_of(falls, steps * step_s, fall_s, expected.turn_rad_per_s);
    if (sigmas >= kClearSigmas) clear.push_back({steps * step_s, 0.0, sigmas});
  }
  std::vector<LightFall> found;
  for (auto one = clear.begin(); one != clear.end(); ++one) {
    bool clearest = true;
    for (auto other = one; other-- != clear.begin() && one->late_s - other->late_s < kApart_s;)
      clearest &= other->sigmas < one->sigmas;
    for (auto other = one + 1; other != clear.end() && other->late_s - one->late_s < kApart_s;
         ++other)
      clearest &= !(other->sigmas > one->sigmas);
    if (!clearest) continue;
    if (const auto fall = refined(falls, *one, expected.turn_rad_per_s)) found.push_back(*fall);
  }
  return found;
}

}  // namespace vildar
