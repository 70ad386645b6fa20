#include "pipeline/broken.h"

namespace vildar {
namespace {

using test::expect_told;

class BrokenSite : public Broken {
 protected:
  /// A run whose site file is a good one with `from` replaced by `to`.
  test::Ran run_with(const std::string& from, const std::string& to) const {
    std::string text = test::bytes_of(site());
    const std::size_t at = text.find(from);
    if (at == std::string::npos) throw std::runtime_error("the site file has no " + from);
    return run_site(text.replace(at, from.size(), to));
  }
  test::Ran run_site(const std::string& text) const {
    return run({clip({.path = path("clip.mkv"), .frames = 2}), "--site", write("bad.yaml", text)});
  }
};

TEST_F(BrokenSite, FaultsAreTwoAndNameFileLineKeyAndRemedy) {
  const struct {
    const char *from, *to;
    std::initializer_list<const char*> told;
  } cases[] = {
      {"focal_px", "focl_px", {"bad.yaml:4", "camera.focl_px", "did you mean \"focal_px\"?"}},
      {"[60, 60]", "[60, wide]", {"bad.yaml:4", "camera.focal_px", "\"wide\"", "is not a number"}},
      {"[60, 60]", "60", {"bad.yaml:4", "camera.focal_px", "is not a list of 2"}},
      {"[60, 60]", "\"60\"", {"bad.yaml:4", "camera.focal_px"}},
      {"[60, 60]", "[.nan, 60]", {"bad.yaml:4", "camera.focal_px"}},
      {"[60, 60]", "[nan, 60]", {"bad.yaml:4", "nan is not finite"}},
      {"[60, 60]", "[inf, 60]", {"bad.yaml:4", "inf is not finite"}},
      {"[60, 60]", "[1e999, 60]", {"bad.yaml:4", "beyond what a number can hold"}},
      {"pitch_deg: -4",
       "pitch_deg: {mean: 1, std: -1}",
       {"bad.yaml:7", "camera.pitch_deg", ">= 0"}},
      {"[64, 48]", "[64, -48]", {"bad.yaml:3", "camera.image_size_px", "out of range"}},
      {"pitch_deg: -4",
       "pitch_deg: -4\n  pitch_deg: -5",
       {"bad.yaml:8", "stands twice", "keep one"}},
      {"version: 1", "version: 9", {"bad.yaml:1", "version"}},
      {"direction: oncoming", "direction: onward", {"bad.yaml:12", "direction", "oncoming"}},
      {"lanes:", "lanes: [", {"bad.yaml:", "not valid YAML", "check indentation"}},
  };
  for (const auto& [from, to, told] : cases) {
    SCOPED_TRACE(to);
    expect_told(run_with(from, to), 2, told);
    EXPECT_TRUE(test::files_in(out()).empty()) << "nothing is written";
  }
}

TEST_F(BrokenSite, EveryFaultIsToldAtOnce) {
  expect_told(run_site("version: 1\ncamera: {focl_px: 1}\nroad: {kind: wavy}\n"), 2,
              {"focl_px", "camera.image_size_px", "road.kind"});
}

TEST_F(BrokenSite, ABendAheadOfAMovingCameraIsWarnedOf) {
  const auto with_straight = [&](const char* straight) {
    std::string text = test::bytes_of(site());
    const std::string kind = "kind: straight";
    const std::size_t at = text.find(kind);
    if (at == std::string::npos) throw std::runtime_error("the site's road is not straight");
    const std::string curved = "kind: curved\n  radius_m: 200\n  turn: left";
    text.replace(at, kind.size(), curved + straight);
    return run_site(text + "ego: {speed_mps: 15}\n");
  };
  expect_told(with_straight("\n  straight_m: 20"), 0,
              {"bad.yaml", "road.straight_m", "straight_m: 0"});
  const auto at_once = with_straight("");
  EXPECT_EQ(at_once.code, 0);
  EXPECT_EQ(at_once.err.find("road.straight_m"), std::string::npos);
}

// Street lamps come by, and nobody told why.
TEST_F(BrokenSite, ADashcamWithoutItsOwnMotionIsWarnedOf) {
  std::string text = test::bytes_of(sample("dashcam") / "site.yaml");
  const auto run_sample = [&] {
    return run({(sample("dashcam") / "clip.mp4").string(), "--site", write("site.yaml", text)});
  };
  const auto told = run_sample();
  EXPECT_EQ(told.code, 0);
  EXPECT_EQ(told.err.find("lights moved through the picture"), std::string::npos);
  const std::size_t at = text.find("ego:");
  ASSERT_NE(at, std::string::npos);
  const std::size_t next = text.find("\n", text.find("\n", at) + 1) + 1;
  text.erase(at, next - at);
  expect_told(run_sample(), 0,
              {"lights moved through the picture", "a camera that drives needs ego"});
}

// By an offset from the middle, as some tools give it; truth of the one that fits: 25 m/s, not 2.8.
TEST_F(BrokenSite, WhereMostVehiclesContradictItNoneIsMeasured) {
  std::string text = test::bytes_of(sample("straight") / "site.yaml");
  const std::size_t at = text.find("principal_px:");
  ASSERT_NE(at, std::string::npos);
  text.replace(at, text.find("\n", at) - at, "principal_px: [0, 0]");
  expect_told(run({(sample("straight") / "clip.mp4").string(), "--site", write("site.yaml", text)}),
              0, {"vehicles do not move as on the road stated", "is in doubt, too"});
  const std::string speeds = test::bytes_of(out() / "speeds.csv");
  EXPECT_NE(speeds.find("withheld:bad_fit"), std::string::npos) << speeds;
  EXPECT_EQ(speeds.find(",measured,"), std::string::npos) << speeds;
}

TEST_F(BrokenSite, AnOwnSpeedInKilometresAnHourIsWarnedOf) {
  const auto fast = run_site(test::bytes_of(site()) + "ego: {speed_mps: 45}\n");
  EXPECT_EQ(fast.code, 0);
  EXPECT_EQ(fast.err.find("km/h"), std::string::npos);
  expect_told(run_site(test::bytes_of(site()) + "ego: {speed_mps: 72}\n"), 0,
              {"an own speed of 72.0 m/s is 259 km/h", "divided by 3.6"});
}

TEST_F(BrokenSite, WhatIsNoSiteFileIsTwo) {
  const std::string file = clip({.path = path("clip.mkv"), .frames = 2});
  expect_told(run({file, "--site", path("missing.yaml").string()}), 2,
              {"missing.yaml", "does not exist", "check the path"});
  expect_told(run({file, "--site", folder_.path().string()}), 2, {"is a folder"});
  expect_told(run({file, "--site", "/dev/zero"}), 2, {"/dev/zero", "is not a plain file"});
  expect_told(run_site(""), 2, {"bad.yaml", "is empty", "version: 1"});
  expect_told(run_site(std::string("version: 1\n\0", 12)), 2, {"is not a text file"});
  expect_told(run({file, "--site", file}), 2, {"clip.mkv"});
}

TEST_F(BrokenSite, BombsOfAliasesAreRefusedAtOnce) {
  std::string nested = "version: 1\na0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int k = 1; k < 12; ++k) {
    const std::string inner = ", *a" + std::to_string(k - 1);
    nested += "a" + std::to_string(k) + ": &a" + std::to_string(k) + " [x";
    for (int i = 0; i < 10; ++i) nested += inner;
    nested += "]\n";
  }
  expect_told(run_site(nested), 2,
              {"bad.yaml:", "more than 100000 values, counting what aliases repeat"});

  std::string large = "version: 1\na: &a [x, x, x, x]\nb:\n";
  large.reserve(100'000'100);
  while (large.size() < 100'000'000) large += "- *a\n";
  expect_told(run_site(large), 2, {"bad.yaml: has 1000000", "the limit is 1048576"});
  large.resize(1'000'000);
  expect_told(run_site(large + "\n"), 2, {"bad.yaml:", "more than 100000 values"});
  expect_told(run_site("version: " + std::string(100'000, '[')), 2, {"bad.yaml:"});
}

}  // namespace
}  // namespace vildar
