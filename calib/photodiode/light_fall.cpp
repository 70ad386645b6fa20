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
constexpr double kClearSigmas = 10.0;

struct Fit {
  double squares_w2 = 0.0;  // of what is left
  int degrees = 0;
  double fall_w = 0.0;
};

class Falls {
 public:
  Falls(const PowerTrace& trace, std::span<const ExpectedFall> expected, double reach_s)
      : expected_(expected),
        period_s_(std::max(trace.sample_period_s, kShortestBlock_s)),
        around_s_(std::max(kAround_s, kFewestAround * period_s_)),
        blocks_(block_means(trace, expected.front().time_s - reach_s - around_s_,
                            expected.back().time_s + reach_s + around_s_, period_s_, 0.0)),
        noise_w_(trace.noise_sigma_w * std::sqrt(trace.sample_period_s / period_s_)) {}

  double period_s() const { return period_s_; }

  // Light that goes, each lamp's within `fall_s`, after it grew by `growth_per_s`, above a line.
  std::optional<Fit> fit(double late_s, double fall_s, double growth_per_s) const {
    if (!look_at(late_s)) return std::nullopt;
    Eigen::MatrixXd terms(count_, 3);
    for (Eigen::Index i = 0; i < count_; ++i) {
      const double t_s = after_first_s(i, late_s);
      double left = 0.0;
      for (const ExpectedFall& one : expected_) {
        const double after_s = t_s - (one.time_s - expected_.front().time_s);
        left += one.share * std::exp(growth_per_s * after_s) *
                std::clamp(0.5 - after_s / fall_s, 0.0, 1.0);
      }
      terms.row(i) << 1.0, t_s / around_s_, left;
    }
    Eigen::VectorXd found;
    Fit fit = solved(terms, found);
    fit.fall_w = found[2];
    return fit;
  }

  // Light that does not fall.
  std::optional<Fit> smooth_fit(double late_s) const {
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
  const PowerBlock& block(Eigen::Index i) const {
    return blocks_[first_ + static_cast<std::size_t>(i)];
  }
  double after_first_s(Eigen::Index i, double late_s) const {
    return block(i).time_s - late_s - expected_.front().time_s;
  }

  // Whether the trace has all that lies about the falls.
  bool look_at(double late_s) const {
    constexpr double kMostMissing = 0.1;
    const double from_s = expected_.front().time_s + late_s - around_s_;
    const double to_s = expected_.back().time_s + late_s + around_s_;
    const auto by_time = [](const PowerBlock& one, double time_s) { return one.time_s < time_s; };
    const auto first = std::lower_bound(blocks_.begin(), blocks_.end(), from_s, by_time);
    const auto last = std::lower_bound(first, blocks_.end(), to_s, by_time);
    first_ = static_cast<std::size_t>(first - blocks_.begin());
    count_ = last - first;
    return static_cast<double>(count_) > (1.0 - kMostMissing) * (to_s - from_s) / period_s_;
  }

  Fit solved(const Eigen::MatrixXd& terms, Eigen::VectorXd& found) const {
    Eigen::VectorXd light_w(count_);
    for (Eigen::Index i = 0; i < count_; ++i) light_w[i] = block(i).power_w;
    found = terms.colPivHouseholderQr().solve(light_w);
    return {(terms * found - light_w).squaredNorm(), static_cast<int>(count_ - terms.cols()), 0.0};
  }

  std::span<const ExpectedFall> expected_;
  double period_s_, around_s_;
  std::vector<PowerBlock> blocks_;
  double noise_w_;
  mutable std::size_t first_ = 0;  // of the blocks looked at
  mutable Eigen::Index count_ = 0;
};

// How clearly the light falls there; zero where it does not.
double sigmas_of(const Falls& falls, double late_s, double fall_s, double turn_rad_per_s) {
  const auto smooth = falls.smooth_fit(late_s);
  if (!smooth) return 0.0;
  double most = 0.0;
  for (const double growth_per_rad : {-9.0, -6.0, -3.0, 0.0}) {
    const auto fit = falls.fit(late_s, fall_s, growth_per_rad * turn_rad_per_s);
    if (!fit || !(fit->fall_w > 0.0)) continue;
    most = std::max(most, (smooth->squares_w2 - fit->squares_w2) / falls.variance_w2(*fit));
  }
  return std::sqrt(most);
}

// The likeliest moment near a fall, over how long it takes, for lamps have a size, and how the
// light had changed before.
std::optional<LightFall> refined(const Falls& falls, LightFall fall, double turn_rad_per_s) {
  constexpr double kLongestFall_s = 0.030;
  constexpr int kSteps = 8;
  const double period_s = falls.period_s();
  const double step_s = period_s / kSteps;
  double best_s = fall.late_s, best_fall_s = period_s, best_growth = 0.0, least_w2 = INFINITY;
  for (double fall_s = period_s; fall_s <= std::max(period_s, kLongestFall_s); fall_s *= 1.5)
    for (double growth = -12.0; growth <= 2.0; growth += 1.0)
      for (int k = -2 * kSteps; k <= 2 * kSteps; ++k) {
        const auto fit = falls.fit(fall.late_s + k * step_s, fall_s, growth * turn_rad_per_s);
        if (!fit || !(fit->squares_w2 < least_w2)) continue;
        least_w2 = fit->squares_w2;
        best_s = fall.late_s + k * step_s;
        best_fall_s = fall_s;
        best_growth = growth * turn_rad_per_s;
      }
  const auto at = falls.fit(best_s, best_fall_s, best_growth);
  const auto early = falls.fit(best_s - period_s, best_fall_s, best_growth);
  const auto late = falls.fit(best_s + period_s, best_fall_s, best_growth);
  if (!at || !early || !late) return std::nullopt;
  const double curvature =
      (early->squares_w2 + late->squares_w2 - 2.0 * at->squares_w2) / (period_s * period_s);
  if (!(curvature > 0.0)) return std::nullopt;
  fall.late_s = best_s;
  // When within a sample the light went, no sample tells.
  fall.std_s =
      std::hypot(std::sqrt(2.0 * falls.variance_w2(*at) / curvature), period_s / std::sqrt(12.0));
  return fall;
}

}  // namespace

std::vector<LightFall> light_falls(const PowerTrace& trace, std::span<const ExpectedFall> expected,
                                   double turn_rad_per_s, double reach_s) {
  const Falls falls(trace, expected, reach_s);
  const double step_s = std::max(kFinestStep_s, falls.period_s());
  const auto steps = static_cast<int>(std::ceil(reach_s / step_s));
  std::vector<LightFall> all;
  for (int k = -steps; k <= steps; ++k)
    all.push_back({k * step_s, 0.0,
                   sigmas_of(falls, k * step_s, std::max(step_s, kLikelyFall_s), turn_rad_per_s)});
  std::vector<LightFall> found;
  for (const LightFall& one : all) {
    if (one.sigmas < kClearSigmas) continue;
    const bool clearest = std::ranges::none_of(all, [&](const LightFall& other) {
      return std::abs(other.late_s - one.late_s) < kApart_s && other.sigmas > one.sigmas;
    });
    if (!clearest) continue;
    if (const auto fall = refined(falls, one, turn_rad_per_s)) found.push_back(*fall);
  }
  return found;
}

}  // namespace vildar
