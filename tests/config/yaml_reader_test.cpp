#include "config/yaml_reader.h"

#include <gtest/gtest.h>

#include "core/random.h"
#include "support/temporary_folder.h"

namespace vildar {
namespace {

std::vector<Problem> problems_of(const YamlReader& reader) {
  try {
    reader.finish();
  } catch (const ConfigError& error) {
    return error.problems();
  }
  return {};
}

/// The problems of a text that cannot even be opened for reading key by key.
std::vector<Problem> refusal_of(std::string_view text) {
  try {
    YamlReader reader(text, "a.yaml");
  } catch (const ConfigError& error) {
    return error.problems();
  }
  return {};
}

/// The one problem that reading `text` with `read` gives.
template <class Read>
Problem problem_of(std::string_view text, Read read) {
  const YamlReader reader(text, "a.yaml");
  read(reader.root());
  const std::vector<Problem> problems = problems_of(reader);
  EXPECT_EQ(problems.size(), 1u) << text;
  return problems.empty() ? Problem{} : problems.front();
}

enum class Colour { red, green };
constexpr std::array<Choice<Colour>, 2> kColours{{{"red", Colour::red}, {"green", Colour::green}}};

TEST(YamlReader, ReadsEveryKindOfValue) {
  const YamlReader reader(
      "number: +1.5e1\ncount: -3\nseed: 18446744073709551615\nyes: true\nname: \"1\"\n"
      "colour: green\npair: [1, 2]\nmany: [.5, 1., 1e-3]\nknown: 4\nprior: {mean: 1, std: 2}\n"
      "angle_deg: 180\nspread_deg: {mean: 90, std: 45}\nfile: sub/x.csv\n"
      "list:\n- {a: 1}\n- {a: 2}\n",
      "/somewhere/a.yaml");
  const YamlMap root = reader.root();
  double number = 0, angle_rad = 0;
  int count = 0;
  std::uint64_t seed = 0;
  bool yes = false;
  std::string name;
  Colour colour = Colour::red;
  std::array<int, 2> pair{};
  std::vector<double> many;
  std::optional<double> known, absent;
  Uncertain prior;
  std::optional<Uncertain> spread_rad;
  std::filesystem::path file;
  root.require("number", number);
  root.require("count", count);
  root.require("seed", seed);
  root.require("yes", yes);
  root.require("name", name);
  root.require("colour", colour, kColours);
  root.require("pair", pair);
  root.require("many", many);
  root.require("known", known);
  root.read("absent", absent);
  root.require("prior", prior);
  root.require_degrees("angle_deg", angle_rad);
  root.read_degrees("spread_deg", spread_rad);
  root.require("file", file);
  const std::vector<YamlMap> list = root.maps("list");
  ASSERT_EQ(list.size(), 2u);
  std::array<int, 2> elements{};
  for (std::size_t i = 0; i < 2; ++i) list[i].require("a", elements[i]);
  EXPECT_NO_THROW(reader.finish());

  EXPECT_EQ(number, 15.0);
  EXPECT_EQ(count, -3);
  EXPECT_EQ(seed, 18446744073709551615u);
  EXPECT_TRUE(yes);
  EXPECT_EQ(name, "1");
  EXPECT_EQ(colour, Colour::green);
  EXPECT_EQ(pair, (std::array<int, 2>{1, 2}));
  EXPECT_EQ(many, (std::vector<double>{0.5, 1.0, 0.001}));
  EXPECT_EQ(known, 4.0);
  EXPECT_FALSE(absent);
  EXPECT_EQ(prior, (Uncertain{1.0, 2.0}));
  EXPECT_DOUBLE_EQ(angle_rad, kPi);
  ASSERT_TRUE(spread_rad);
  EXPECT_DOUBLE_EQ(spread_rad->mean, kPi / 2);
  EXPECT_DOUBLE_EQ(spread_rad->std, kPi / 4);
  EXPECT_EQ(file, "/somewhere/sub/x.csv");
  EXPECT_EQ(elements, (std::array<int, 2>{1, 2}));
}

TEST(YamlReader, NumbersThatAreNoneAreNamedWithTheirLine) {
  for (const char* text : {"abc", "1.5m", "1,5", "\"1.5\"", "0x10", "[1]", "{a: 1}", "1 2", ".nan",
                           ".inf", "nan", "inf", "-inf", "1e999", "--1", "+-1", "~", ""}) {
    double value = 7.0;
    const Problem problem = problem_of("# a comment\nx: " + std::string(text) + "\n",
                                       [&](const YamlMap& root) { root.require("x", value); });
    EXPECT_EQ(problem.line, 2) << text;
    EXPECT_EQ(problem.key, "x") << text;
    EXPECT_FALSE(problem.fault.empty()) << text;
    EXPECT_FALSE(problem.remedy.empty()) << text;
    EXPECT_EQ(value, 7.0) << text;
  }
}

TEST(YamlReader, RangeRulesHoldAtTheirEnds) {
  constexpr NumberRule kHalfOpen{0.0, 90.0, true, false};
  for (const auto& [text, fits] : std::vector<std::pair<std::string, bool>>{
           {"0", false}, {"1e-9", true}, {"90", true}, {"90.0001", false}, {"-1", false}}) {
    const YamlReader reader("x: " + text + "\n", "a.yaml");
    double value = 0.0;
    reader.root().require("x", value, kHalfOpen);
    const std::vector<Problem> problems = problems_of(reader);
    EXPECT_EQ(problems.empty(), fits) << text;
    if (!fits) {
      EXPECT_EQ(problems.at(0).fault, text + " is out of range");
      EXPECT_EQ(problems.at(0).remedy, "must be > 0 and <= 90");
    }
  }
}

TEST(YamlReader, WholeNumbersAreNotRounded) {
  for (const char* text : {"1920.0", "1e3", "2147483648", "-1", "abc", "99999999999999999999"}) {
    int value = 0;
    problem_of("x: " + std::string(text) + "\n",
               [&](const YamlMap& root) { root.require("x", value, kPositive); });
    EXPECT_EQ(value, 0) << text;
  }
}

TEST(YamlReader, ListsOfFixedLengthNameTheElement) {
  std::array<double, 2> pair{};
  const auto read = [&](const YamlMap& root) {
    if (const auto camera = root.map("camera")) camera->require("focal_px", pair, kPositive);
  };
  Problem problem = problem_of("camera:\n  focal_px:\n  - 1400\n  - -5\n", read);
  EXPECT_EQ(problem.key, "camera.focal_px[1]");
  EXPECT_EQ(problem.line, 4);
  EXPECT_EQ(problem.fault, "-5 is out of range");
  EXPECT_EQ(problem.remedy, "must be > 0");
  problem = problem_of("camera:\n  focal_px: [1, 2, 3]\n", read);
  EXPECT_EQ(problem.key, "camera.focal_px");
  EXPECT_NE(problem.fault.find("a list of 3"), std::string::npos);
  EXPECT_NE(problem.remedy.find("2 values"), std::string::npos);
}

TEST(YamlReader, UncertainNeedsBothPartsAndNoOthers) {
  Uncertain value;
  const auto read = [&](const YamlMap& root) { root.require("x", value); };
  EXPECT_EQ(problem_of("x: {mean: 1}\n", read).key, "x.std");
  EXPECT_EQ(problem_of("x: {std: 1}\n", read).key, "x.mean");
  EXPECT_EQ(problem_of("x: {mean: 1, std: -1}\n", read).key, "x.std");
  EXPECT_EQ(problem_of("x: {mean: .nan, std: 1}\n", read).key, "x.mean");
  EXPECT_EQ(problem_of("x: {mean: 1, std: 1, sdt: 1}\n", read).remedy, "did you mean \"std\"?");
  EXPECT_EQ(problem_of("x: [1, 2]\n", read).key, "x");
  EXPECT_EQ(value, (Uncertain{1.0, 1.0}));  // only the one with a stray key had sound values
}

TEST(YamlReader, UnknownWordsAndKeysGetTheNearestKnown) {
  Colour colour = Colour::red;
  const auto read = [&](const YamlMap& root) { root.read("colour", colour, kColours); };
  Problem problem = problem_of("colour: gren\n", read);
  EXPECT_NE(problem.remedy.find("did you mean \"green\"?"), std::string::npos);
  EXPECT_NE(problem.remedy.find("red, green"), std::string::npos);
  problem = problem_of("\ncolor: green\n", read);
  EXPECT_EQ(problem.line, 2);
  EXPECT_EQ(problem.key, "color");
  EXPECT_EQ(problem.remedy, "did you mean \"colour\"?");
  double speed_mps = 0.0;
  problem = problem_of("speed_kmh: 50\n",
                       [&](const YamlMap& root) { root.read("speed_mps", speed_mps); });
  EXPECT_EQ(problem.remedy,
            "did you mean \"speed_mps\"? It is in metres per second: km/h divided by 3.6");
  problem = problem_of("something_else: 1\n", read);
  EXPECT_NE(problem.remedy.find("colour"), std::string::npos);
}

TEST(YamlReader, MissingKeysCarryTheLineOfTheirMap) {
  double value = 0.0;
  const Problem problem =
      problem_of("first: 1\n\nouter:\n  # nothing yet\n  other: 2\n", [&](const YamlMap& root) {
        root.require("first", value);
        const auto outer = root.require_map("outer");
        outer->require("other", value);
        outer->require("wanted", value);
      });
  EXPECT_EQ(problem.key, "outer.wanted");
  EXPECT_EQ(problem.line, 3);
  EXPECT_EQ(problem.fault, "is missing");
}

TEST(YamlReader, AKeyTwiceIsNamedWhereItStandsTheSecondTime) {
  double value = 0.0;
  const Problem problem = problem_of("x: 1\ny: 2\nx: 1\n", [&](const YamlMap& root) {
    root.require("x", value);
    root.require("y", value);
  });
  EXPECT_EQ(problem.line, 3);
  EXPECT_NE(problem.fault.find("twice"), std::string::npos);
}

TEST(YamlReader, AllProblemsComeAtOnceInOrderOfLine) {
  const YamlReader reader("e: 1\nd: x\nc: -1\nb: 1\nb: 1\n", "a.yaml");
  double value = 0.0;
  reader.root().read("b", value);
  reader.root().read("c", value, kPositive);
  reader.root().read("d", value);
  const std::vector<Problem> problems = problems_of(reader);
  ASSERT_EQ(problems.size(), 4u);
  const std::vector<int> lines{problems[0].line, problems[1].line, problems[2].line,
                               problems[3].line};
  EXPECT_EQ(lines, (std::vector<int>{1, 2, 3, 5}));
  EXPECT_EQ(to_string(problems[2]), "a.yaml:3: c: -1 is out of range; must be > 0");
}

TEST(YamlReader, AFloodOfProblemsIsCutShortAndCounted) {
  std::string text;
  for (int i = 0; i < 1000; ++i) text += "stray_" + std::to_string(i) + ": 1\n";
  const std::vector<Problem> problems = problems_of(YamlReader(text, "a.yaml"));
  ASSERT_EQ(problems.size(), 101u);
  EXPECT_NE(problems.back().fault.find("900 more"), std::string::npos);
}

TEST(YamlReader, RefuseMarksAKeyThatHasNoPlace) {
  const Problem problem = problem_of("x: 1\n", [](const YamlMap& root) {
    root.refuse("x", "belongs elsewhere", "move it");
    root.refuse("absent", "belongs elsewhere", "move it");
  });
  EXPECT_EQ(problem.fault, "belongs elsewhere");
}

TEST(YamlDocument, SyntaxErrorsCarryTheirLine) {
  const std::vector<Problem> problems = refusal_of("a: 1\nb: 2\nc: [1, 2\nd: 3\n");
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_GE(problems[0].line, 3);
  EXPECT_LE(problems[0].line, 4);
  EXPECT_NE(problems[0].fault.find("not valid YAML"), std::string::npos);
  EXPECT_EQ(refusal_of("a: 1\n b: 2\n").at(0).line, 2);
  EXPECT_EQ(refusal_of("a: 1\n---\nb: 2\n").at(0).line, 2);
  EXPECT_EQ(refusal_of("a: 1\nb: !!python/object x\n").at(0).line, 2);
  EXPECT_EQ(refusal_of("a: 1\n[1, 2]: 3\n").at(0).line, 2);
}

TEST(YamlDocument, WhatIsNoMapOrEmptyIsRefused) {
  for (const char* text : {"", "# only a comment\n", "---\n", "~\n", "- 1\n- 2\n", "word\n"})
    EXPECT_EQ(refusal_of(text).size(), 1u) << text;
  EXPECT_EQ(refusal_of(std::string_view("a: 1\0b", 6)).size(), 1u);
}

TEST(YamlDocument, AliasesStandForTheirValue) {
  const YamlReader reader("a: &x {mean: 1, std: 2}\nb: *x\n", "a.yaml");
  Uncertain a, b;
  reader.root().require("a", a);
  reader.root().require("b", b);
  EXPECT_NO_THROW(reader.finish());
  EXPECT_EQ(a, b);
}

TEST(YamlDocument, AliasBombsAndEndlessAliasesAreRefused) {
  std::string bomb = "l0: &l0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 40; ++i) {
    const std::string below = "*l" + std::to_string(i - 1);
    bomb += "l" + std::to_string(i) + ": &l" + std::to_string(i) + " [";
    for (int j = 0; j < 10; ++j) bomb += (j ? ", " : "") + below;
    bomb += "]\n";
  }
  const std::vector<Problem> problems = refusal_of(bomb);
  ASSERT_EQ(problems.size(), 1u);
  // Ten values, then ten times as many on each line: the hundred thousand are passed on line 5.
  EXPECT_EQ(problems[0].line, 5);
  EXPECT_EQ(refusal_of("a: &a [*a]\n").size(), 1u);
  EXPECT_EQ(refusal_of("a: *nowhere\n").size(), 1u);
}

TEST(YamlDocument, DepthAndSizeAreBounded) {
  EXPECT_EQ(refusal_of("a: " + std::string(100'000, '[')).size(), 1u);
  std::string many = "a: [";
  for (std::size_t i = 0; i <= kMostYamlNodes; ++i) many += "1,";
  EXPECT_EQ(refusal_of(many + "1]\n").size(), 1u);
  EXPECT_EQ(refusal_of("a: " + std::string(kLargestYaml_bytes, 'x')).size(), 1u);
}

TEST(YamlDocument, FilesThatCannotBeReadAreNamed) {
  const TemporaryFolder folder;
  folder.write("empty.yaml", "");
  folder.write("large.yaml", std::string(kLargestYaml_bytes + 1, '#'));
  for (const char* name : {"absent.yaml", ".", "empty.yaml", "large.yaml"}) {
    const std::filesystem::path file = folder.path() / name;
    try {
      YamlReader reader(file);
      ADD_FAILURE() << name << " was read";
    } catch (const ConfigError& error) {
      ASSERT_EQ(error.problems().size(), 1u) << name;
      EXPECT_EQ(error.problems()[0].file, file.string());
      EXPECT_FALSE(error.problems()[0].remedy.empty()) << name;
    }
  }
  EXPECT_THROW(YamlReader("/dev/null"), ConfigError);
}

// Whatever the bytes, the answer is a tree or a ConfigError.
TEST(YamlDocument, BytesChangedAtRandomNeverDoMoreThanThrow) {
  constexpr int kTrials = 3000;
  const std::string sound =
      "a: &x {mean: 1, std: [2, 'q']}\nb:\n- *x\n- \"t\\n\"\nc: |\n  text\nd: !t v\n? k\n: v\n";
  constexpr std::string_view kBytes = "{}[]:,-?&*!|>'\"%@`#\n\t \\~0a\xff\xc3\x01";
  Random random(20260301);
  int read = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::string text = sound;
    for (int change = 0; change < 3; ++change) {
      const auto at = static_cast<std::size_t>(random.uniform() * static_cast<double>(text.size()));
      const auto with =
          static_cast<std::size_t>(random.uniform() * static_cast<double>(kBytes.size()));
      text[at] = kBytes[with];
    }
    try {
      parse_yaml_text(text, "a.yaml");
      ++read;
    } catch (const ConfigError& error) {
      EXPECT_EQ(error.problems().size(), 1u);
    }
  }
  EXPECT_LT(read, kTrials);
}

}  // namespace
}  // namespace vildar
