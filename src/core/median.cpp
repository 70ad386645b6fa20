#include "core/median.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vildar {

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double robust_sigma(std::vector<double> values) {
  constexpr double kSigmaPerMad = 1.4826;
  for (double& value : values) value = std::abs(value);
  return kSigmaPerMad * median(std::move(values));
}

}  // namespace vildar
