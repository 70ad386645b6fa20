#include "optics/ego_trace.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <utility>

#include <Eigen/Core>

#include "core/median.h"

namespace vildar {

double trace_noise(std::span<const double> values) {
  if (values.size() < 5) return 0.0;
  std::vector<double> differences;
  for (std::size_t i = 2; i + 2 < values.size(); ++i)
    differences.push_back(values[i - 2] - 4.0 * values[i - 1] + 6.0 * values[i] -
                          4.0 * values[i + 1] + values[i + 2]);
  return robust_sigma(std::move(differences)) / std::sqrt(70.0);
}

std::vector<EgoSample> without_speed_noise(std::vector<EgoSample> trace, const TimeSpan& watched) {
  constexpr double kBesides_s = 0.5;
  constexpr int kFewest = 8, kHighest = 10;
  constexpr double kMuch = 1.35;  // differences of few samples tell the noise to a third
  std::vector<double> speeds_mps;
  std::ranges::transform(trace, std::back_inserter(speeds_mps), &EgoSample::speed_mps);
  const double noise_mps = trace_noise(speeds_mps);
  const auto first =
      std::ranges::lower_bound(trace, watched.from_s - kBesides_s, {}, &EgoSample::time_s);
  const auto last =
      std::ranges::upper_bound(trace, watched.to_s + kBesides_s, {}, &EgoSample::time_s);
  const auto count = static_cast<int>(last - first);
  if (count < kFewest) return trace;
  // Polynomials that are orthogonal over the samples, by Forsythe's recursion.
  Eigen::ArrayXd place(count), left_mps(count);
  for (int i = 0; i < count; ++i) {
    place[i] = 2.0 * (first[i].time_s - first->time_s) / ((last - 1)->time_s - first->time_s) - 1.0;
    left_mps[i] = first[i].speed_mps;
  }
  Eigen::ArrayXd before = Eigen::ArrayXd::Zero(count), now = Eigen::ArrayXd::Ones(count);
  double before_square = 1.0;
  for (int degree = 0; degree <= std::min(kHighest, count / 2); ++degree) {
    const double square = now.square().sum();
    left_mps -= (left_mps * now).sum() / square * now;
    if (left_mps.square().sum() <= std::pow(kMuch * noise_mps, 2) * (count - degree - 1)) {
      for (int i = 0; i < count; ++i) first[i].speed_mps -= left_mps[i];
      return trace;
    }
    Eigen::ArrayXd next = (place - (place * now.square()).sum() / square) * now;
    if (degree > 0) next -= square / before_square * before;
    before = std::exchange(now, std::move(next));
    before_square = square;
  }
  return trace;
}

}  // namespace vildar
