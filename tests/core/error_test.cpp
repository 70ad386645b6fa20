#include "core/error.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "core/outcome.h"

namespace vildar {
namespace {

TEST(Problem, IsOneLineWithWhatIsKnown) {
  EXPECT_EQ(to_string({"a.yaml", 3, "x.y", "is bad", "mend it"}), "a.yaml:3: x.y: is bad; mend it");
  EXPECT_EQ(to_string({"a.yaml", 0, "", "is bad", ""}), "a.yaml: is bad");
}

TEST(ConfigError, SaysAllOfItsProblems) {
  const ConfigError error({{"a", 1, "k", "f", "r"}, {"a", 2, "l", "g", ""}});
  EXPECT_STREQ(error.what(), "a:1: k: f; r\na:2: l: g");
  EXPECT_EQ(error.problems().size(), 2u);
}

TEST(Miss, EveryReasonHasANameOfItsOwn) {
  std::set<std::string> names;
  constexpr int kReasons = static_cast<int>(Miss::not_on_road) + 1;
  for (int i = 0; i < kReasons; ++i) {
    const std::string name(name_of(static_cast<Miss>(i)));
    EXPECT_EQ(name.find_first_not_of("abcdefghijklmnopqrstuvwxyz_"), std::string::npos) << name;
    EXPECT_NE(name, "unknown");
    names.insert(name);
  }
  EXPECT_EQ(names.size(), static_cast<std::size_t>(kReasons));
}

}  // namespace
}  // namespace vildar
