#include "estimate/power_start.h"

#include <algorithm>
#include <cmath>

#include "estimate/power_inverse.h"
#include "estimate/power_least_squares.h"

namespace vildar {
namespace {

// Means over stretches of about ten samples, 8 to 30 of them.
PowerSamples block_means(const PowerSamples& samples) {
  const std::size_t n = samples.time_s.size();
  const std::size_t count = std::min(n, std::clamp<std::size_t>(n / 10, 8, 30));
  PowerSamples blocks;
  for (std::size_t b = 0; b < count; ++b) {
    double weight = 0.0, time = 0.0, power = 0.0;
    for (std::size_t i = b * n / count; i < (b + 1) * n / count; ++i) {
      weight += samples.weight[i];
      time += samples.weight[i] * samples.time_s[i];
      power += samples.weight[i] * samples.power_w[i];
    }
    blocks.time_s.push_back(time / weight);
    blocks.power_w.push_back(power / weight);
    blocks.weight.push_back(weight);
  }
  return blocks;
}

// Speed and range from the line through the implied path lengths of blocks [from, to).
bool fit_path(const PowerSamples& blocks, std::size_t from, std::size_t to, double side,
              const PowerSetting& setting, const std::optional<Uncertain>& speed_prior,
              PowerVector& value) {
  constexpr double kFarFromPrior = 2.0;  // sigmas: then the line says less than the prior
  const std::span<const double> power(blocks.power_w.data() + from, to - from);
  const ImpliedPath path = implied_path(power, value, setting);
  const double half_a = 0.5 * value[kPowerAcceleration];
  double w = 0.0, wt = 0.0, wy = 0.0, wtt = 0.0, wty = 0.0;
  for (int pass = 0; pass < 2; ++pass) {
    const double mean_t = w > 0.0 ? wt / w : 0.0, mean_y = w > 0.0 ? wy / w : 0.0;
    for (std::size_t i = 0; i < power.size(); ++i) {
      if (!path.inside[i]) continue;
      const double t = blocks.time_s[from + i];
      const double y = side * path.along_m[i] + half_a * t * t;
      const double weight = blocks.weight[from + i] * path.steepness[i] * path.steepness[i];
      if (pass == 0) {
        w += weight;
        wt += weight * t;
        wy += weight * y;
      } else {
        wtt += weight * (t - mean_t) * (t - mean_t);
        wty += weight * (t - mean_t) * (y - mean_y);
      }
    }
  }
  if (!(wtt > 0.0)) return false;
  value[kPowerSpeed] = -wty / wtt;
  if (speed_prior &&
      std::abs(value[kPowerSpeed] - speed_prior->mean) > kFarFromPrior * speed_prior->std)
    value[kPowerSpeed] = speed_prior->mean;
  value[kPowerRange] = wy / w + value[kPowerSpeed] * wt / w;
  return value.allFinite();
}

// Distance that a power implies on axis.
double implied_m(double power_w, const PowerVector& p) {
  return std::exp((p[kPowerLogGain] - std::log(power_w)) / p[kPowerExponent]);
}

// Values to try for what is not known at all, each with the others already in `value`.
class Trials {
 public:
  Trials(const PowerSamples& blocks, const PowerKnowledge& known, const PowerSetting& setting)
      : known_(known), setting_(setting) {
    for (const double power : blocks.power_w)
      if (power > 0.0) {
        brightest_w_ = std::max(brightest_w_, power);
        darkest_w_ = darkest_w_ > 0.0 ? std::min(darkest_w_, power) : power;
      }
  }

  std::vector<PowerVector> all() const {
    std::vector<PowerVector> values{PowerVector::Zero()};
    for (int p = 0; p < kPowerParameters; ++p)
      if (known_[p]) values[0][p] = known_[p]->mean;
    values[0][kPowerSpeed] = values[0][kPowerRange] = 0.0;
    if (!(brightest_w_ > 0.0)) return {};
    expand(values, kPowerExponent, [](const PowerVector&) { return std::vector{1.2, 2.0, 3.0}; });
    if (!known_[kPowerLogGain]) {
      const std::vector<double> lengths = known_lengths_m();
      expand(values, kPowerLogGain, [&](const PowerVector& v) {
        std::vector<double> log_gains;
        for (const double length_m : lengths)
          log_gains.push_back(std::log(brightest_w_) + v[kPowerExponent] * std::log(length_m));
        return log_gains;
      });
    }
    expand(values, kPowerRadius, [&](const PowerVector& v) {
      const double far_m = implied_m(darkest_w_, v);
      return setting_.curved ? std::vector{0.6 * far_m, far_m, 2.0 * far_m, 5.0 * far_m}
                             : std::vector{1.0};
    });
    expand(values, kPowerPerpendicular, [&](const PowerVector& v) {
      const double near_m = implied_m(brightest_w_, v);
      return std::vector{0.1 * near_m, 0.5 * near_m, 0.9 * near_m};
    });
    return values;
  }

 private:
  template <class Values>
  void expand(std::vector<PowerVector>& values, PowerParameter p, Values of) const {
    if (known_[p]) return;
    std::vector<PowerVector> grown;
    for (const PowerVector& value : values)
      for (const double choice : of(value)) {
        grown.push_back(value);
        grown.back()[p] = choice;
      }
    values = std::move(grown);
  }

  // Distances at which the brightest block may lie, judged by the lengths that are known.
  std::vector<double> known_lengths_m() const {
    double length_m = setting_.height_m;
    if (known_[kPowerPerpendicular])
      length_m = std::max(length_m, std::abs(known_[kPowerPerpendicular]->mean));
    if (length_m > 0.0)
      return {1.05 * length_m, 1.5 * length_m, 3.0 * length_m, 8.0 * length_m, 25.0 * length_m};
    if (setting_.curved && known_[kPowerRadius]) length_m = known_[kPowerRadius]->mean;
    if (known_[kPowerRange]) length_m = std::max(1.0, std::abs(known_[kPowerRange]->mean));
    if (!(length_m > 0.0)) length_m = 10.0;
    return {0.1 * length_m, 0.3 * length_m, length_m, 2.0 * length_m};
  }

  const PowerKnowledge& known_;
  const PowerSetting& setting_;
  double brightest_w_ = 0.0, darkest_w_ = 0.0;
};

}  // namespace

std::variant<PowerVector, PowerRefusal> power_start(const PowerSamples& samples,
                                                    const PowerKnowledge& known,
                                                    const PowerSetting& setting) {
  constexpr int kIterations = 12;
  const PowerSamples blocks = block_means(samples);
  const std::size_t count = blocks.time_s.size();
  const auto peak = static_cast<std::size_t>(
      std::max_element(blocks.power_w.begin(), blocks.power_w.end()) - blocks.power_w.begin());
  struct Stretch {
    std::size_t from, to;
    double side;  // +1: not yet past the sensor's cross-line
  };
  std::vector<Stretch> stretches{{0, count, 1.0}};
  const bool inner_peak = peak > 0 && peak + 1 < count;
  if (inner_peak && peak >= 2) stretches.push_back({0, peak + 1, 1.0});
  if (inner_peak && peak + 3 <= count) {
    stretches.push_back({peak, count, 1.0});
    if (setting.cosine_exponent == 0.0) stretches.push_back({peak, count, -1.0});
  }

  PowerVector best = PowerVector::Zero();
  double least = kNoLoss;
  const std::vector<PowerVector> trials = Trials(blocks, known, setting).all();
  PowerLeastSquares squares(blocks, known, setting, kNoLoss);
  const bool alone = trials.size() == 1 && stretches.size() == 1;
  for (const PowerVector& trial : trials)
    for (const Stretch& stretch : stretches) {
      PowerVector value = trial;
      if (!fit_path(blocks, stretch.from, stretch.to, stretch.side, setting, known[kPowerSpeed],
                    value))
        continue;
      if (known[kPowerRange] && !(known[kPowerRange]->std > 0.0))
        value[kPowerRange] = known[kPowerRange]->mean;
      const auto minimum = squares.minimise(value, alone ? 4 : kIterations);
      // Behind the cross-line all the time is a mirror image, on a curve another road.
      const auto along_m = [&](double t_s) {
        return minimum.value[kPowerRange] -
               t_s * (minimum.value[kPowerSpeed] + 0.5 * t_s * minimum.value[kPowerAcceleration]);
      };
      if (!(along_m(blocks.time_s.front()) > 0.0 || along_m(blocks.time_s.back()) > 0.0)) continue;
      if (!(minimum.at.cost < least)) continue;
      least = minimum.at.cost;
      best = minimum.value;
    }
  if (std::isinf(least))
    return PowerRefusal{Miss::outside_model,
                        "the power is greater than the law gives anywhere at this d and K"};
  return best;
}

std::optional<PowerVector> power_start_by_samples(const PowerSamples& samples,
                                                  const PowerKnowledge& known,
                                                  const PowerSetting& setting) {
  PowerVector value = PowerVector::Zero();
  for (const PowerParameter p :
       {kPowerLogGain, kPowerPerpendicular, kPowerExponent, kPowerAcceleration, kPowerRadius}) {
    if (known[p])
      value[p] = known[p]->mean;
    else if (p != kPowerAcceleration && (p != kPowerRadius || setting.curved))
      return std::nullopt;
  }
  if (!fit_path(samples, 0, samples.time_s.size(), 1.0, setting, known[kPowerSpeed], value))
    return std::nullopt;
  return value;
}

}  // namespace vildar
