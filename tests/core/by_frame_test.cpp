#include "core/by_frame.h"

#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace vildar {
namespace {

struct Item {
  int frame;
  char name;
};

using Pairs = std::vector<std::pair<char, char>>;

Pairs common(const std::vector<Item>& first, const std::vector<Item>& second) {
  Pairs found;
  for_each_common_frame(first, second, &Item::frame, [&](const Item& one, const Item& other) {
    found.emplace_back(one.name, other.name);
  });
  return found;
}

TEST(ByFrame, FramesOfBothInTheirOrder) {
  const std::vector<Item> first{{1, 'a'}, {3, 'b'}, {4, 'c'}, {9, 'd'}};
  const std::vector<Item> second{{2, 'p'}, {3, 'q'}, {4, 'r'}, {5, 's'}, {9, 't'}, {12, 'u'}};
  EXPECT_EQ(common(first, second), (Pairs{{'b', 'q'}, {'c', 'r'}, {'d', 't'}}));
  EXPECT_EQ(common(second, first), (Pairs{{'q', 'b'}, {'r', 'c'}, {'t', 'd'}}));
}

TEST(ByFrame, NoneWhereOneHasNone) {
  const std::vector<Item> first{{1, 'a'}, {3, 'b'}};
  EXPECT_TRUE(common(first, {}).empty());
  EXPECT_TRUE(common({}, first).empty());
  EXPECT_TRUE(common(first, {{2, 'p'}, {4, 'q'}}).empty());
}

}  // namespace
}  // namespace vildar
