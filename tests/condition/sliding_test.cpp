#include "condition/sliding.h"

#include <algorithm>
#include <cmath>

#include "core/random.h"

namespace vildar {
namespace {

TEST(Sliding, EqualsASearchOfEveryNeighbourhood) {
  Random random(1);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<double> times_s, values;
    double time_s = 0.0;
    for (int i = 0; i < 60; ++i) {
      times_s.push_back(time_s += random.uniform(0.01, 1.0));
      values.push_back(std::floor(random.uniform(0.0, 20.0)));
    }
    const double reach_s = random.uniform(0.0, 8.0);
    const std::vector<double> least = sliding_minimum(times_s, values, reach_s);
    const std::vector<double> most = sliding_maximum(times_s, values, reach_s);
    for (std::size_t i = 0; i < values.size(); ++i) {
      double low = values[i], high = values[i];
      for (std::size_t k = 0; k < values.size(); ++k) {
        if (times_s[k] < times_s[i] - reach_s || times_s[k] > times_s[i] + reach_s) continue;
        low = std::min(low, values[k]);
        high = std::max(high, values[k]);
      }
      ASSERT_EQ(least[i], low);
      ASSERT_EQ(most[i], high);
    }
  }
  EXPECT_TRUE(sliding_minimum({}, {}, 1.0).empty());
}

}  // namespace
}  // namespace vildar
