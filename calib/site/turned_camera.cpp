#include "calib/site/turned_camera.h"

#include <algorithm>
#include <cmath>

#include "core/quantity.h"

namespace vildar {
namespace {

constexpr int kFewestPasses = 2;
constexpr double kSigmas = 4.0;
const double kLeast_rad = radians_from_degrees(0.1);  // a mount gives by less

struct RunLearned {
  std::size_t run = 0;
  std::vector<LearnedQuantity> quantities;
};

const LearnedQuantity* turn_of(const RunLearned& learned, const std::string& key) {
  const auto found = std::ranges::find(learned.quantities, key, &LearnedQuantity::key);
  return found == learned.quantities.end() || !found->angle ? nullptr : &*found;
}

// What vehicles differ by in a turn, about the means of their runs; the prior of the spread is
// worth one pass, which stands for the one that each run's mean takes.
struct PooledSpread {
  double variance = 0.0, freedom = 1.0;
};

PooledSpread pooled_spread(const std::vector<RunLearned>& runs, const std::string& key) {
  PooledSpread pooled;
  double passes = 0.0;
  for (const RunLearned& run : runs) {
    const LearnedQuantity* turn = turn_of(run, key);
    if (!turn) continue;
    pooled.variance += turn->passes * turn->spread * turn->spread;
    passes += turn->passes;
    pooled.freedom += turn->passes - 1.0;
  }
  pooled.variance /= passes;
  return pooled;
}

// Variance of a run's turn by the bearings alone.
double bearings_variance(const LearnedQuantity& turn) {
  return std::max(0.0, turn.mean_std * turn.mean_std - turn.spread * turn.spread / turn.passes);
}

// Sigmas of a normal error as unlikely as this one, whose variance is in part that of a spread
// estimated from few passes: Welch's and Satterthwaite's degrees of freedom, Wallace's normal
// approximation of Student's t.
double sigmas_apart(const LearnedQuantity& one, const LearnedQuantity& other,
                    const PooledSpread& pooled) {
  const double of_spread = pooled.variance * (1.0 / one.passes + 1.0 / other.passes);
  const double variance = of_spread + bearings_variance(one) + bearings_variance(other);
  const double ratio = variance / of_spread;
  const double freedom = pooled.freedom * ratio * ratio;
  const double apart_rad = one.after.mean - other.after.mean;
  const double square = apart_rad * apart_rad / variance;
  return (8.0 * freedom + 1.0) / (8.0 * freedom + 3.0) *
         std::sqrt(freedom * std::log1p(square / freedom));
}

}  // namespace

std::optional<TurnedCamera> turned_camera(std::span<const std::vector<VehicleTrack>> runs,
                                          const Site& site) {
  // One lens took all runs: what is not known of it parts none of them.
  Site same_lens = site;
  same_lens.camera->focal_std_px = 0.0;
  std::vector<RunLearned> learned;
  for (std::size_t run = 0; run < runs.size(); ++run)
    if (auto outcome = learn_site(runs[run], same_lens, kFewestPasses);
        std::holds_alternative<SiteLearning>(outcome))
      learned.push_back({run, std::get<SiteLearning>(std::move(outcome)).quantities});
  for (std::size_t i = 0; i < learned.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      for (const LearnedQuantity& one : learned[i].quantities) {
        const LearnedQuantity* other = turn_of(learned[k], one.key);
        if (!one.angle || !other) continue;
        if (std::abs(one.after.mean - other->after.mean) < kLeast_rad ||
            sigmas_apart(one, *other, pooled_spread(learned, one.key)) < kSigmas)
          continue;
        return TurnedCamera{learned[i].run, learned[k].run, one, *other};
      }
  return std::nullopt;
}

}  // namespace vildar
