#include "simulate/monte_carlo.h"

#include <set>
#include <stdexcept>

#include <gtest/gtest.h>

namespace vildar::simulate {
namespace {

TEST(MonteCarlo, EveryTrialRunsOnceOnAnyNumberOfThreads) {
  for (const int threads : {0, 1, 2, 7, 100}) {
    std::vector<int> runs(50, 0);
    for_each_trial(50, threads, [&](int i) { ++runs[static_cast<std::size_t>(i)]; });
    EXPECT_EQ(runs, std::vector<int>(50, 1)) << threads;
  }
  for_each_trial(0, 2, [](int) { FAIL(); });
}

TEST(MonteCarlo, AFailureOfATrialComesOut) {
  EXPECT_THROW(for_each_trial(20, 3,
                              [](int i) {
                                if (i == 7) throw std::domain_error("seven");
                              }),
               std::domain_error);
}

TEST(MonteCarlo, SeedsDiffer) {
  std::set<std::uint64_t> seeds;
  for (std::uint64_t seed = 0; seed < 5; ++seed)
    for (std::uint64_t stream = 0; stream < 20; ++stream)
      for (int trial = 0; trial < 100; ++trial) seeds.insert(trial_seed(seed, stream, trial));
  EXPECT_EQ(seeds.size(), 5u * 20u * 100u);
}

}  // namespace
}  // namespace vildar::simulate
