#include "pipelines/terminal_warnings.h"

#include <gtest/gtest.h>

namespace vildar {
namespace {

using Texts = std::vector<std::string>;

TEST(TerminalWarnings, DifferentOnesAreAllTold) {
  const Texts warnings{"the clip ends early", "vehicle 1: it brakes", "vehicle 1: it shines"};
  EXPECT_EQ(terminal_warnings(warnings), warnings);
  EXPECT_TRUE(terminal_warnings(Texts{}).empty());
}

TEST(TerminalWarnings, OfManyThatDifferInNumbersTheFirstThreeAndTheCount) {
  Texts warnings;
  for (int i = 1; i <= 12; ++i)
    warnings.push_back("vehicle " + std::to_string(i) + ": at y = " + std::to_string(-0.5 * i));
  warnings.insert(warnings.begin() + 5, "the clip ends early");
  EXPECT_EQ(terminal_warnings(warnings),
            (Texts{warnings[0], warnings[1], warnings[2],
                   "and 9 more like the last one (run.json has them all)", "the clip ends early"}));
}

TEST(TerminalWarnings, OneMoreIsNoShorterAsACount) {
  const Texts warnings{"vehicle 1: late", "vehicle 2: late", "vehicle 3: late", "vehicle 4: late"};
  EXPECT_EQ(terminal_warnings(warnings), warnings);
}

}  // namespace
}  // namespace vildar
