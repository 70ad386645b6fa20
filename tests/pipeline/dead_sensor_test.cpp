#include <sndfile.h>

#include <cmath>
#include <functional>
#include <sstream>

#include "core/random.h"
#include "pipeline/broken.h"

namespace vildar {
namespace {

using test::bytes_of;
using test::expect_told;
using test::Ran;

/// Whole runs in which one sensor of several gives nothing.
class DeadSensor : public Broken {
 protected:
  /// A sample's trace with one column (the first after the time is 1) written anew.
  std::string with_column(const std::string& trace, std::size_t column,
                          const std::function<std::string(const std::string&)>& value) const {
    std::istringstream lines(bytes_of(trace));
    std::string text, line;
    std::getline(lines, line);
    text = line + "\n";
    while (std::getline(lines, line)) {
      std::size_t from = 0;
      for (std::size_t k = 0; k < column; ++k) from = line.find(',', from) + 1;
      const std::size_t to = std::min(line.find(',', from), line.size());
      text += line.substr(0, from) + value(line.substr(from, to - from)) + line.substr(to) + "\n";
    }
    return write("trace.csv", text);
  }
  std::string speeds() const { return bytes_of(out() / "speeds.csv"); }
  static std::size_t lines_of(const std::string& text) {
    return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  }
};

TEST_F(DeadSensor, OnePhotodiodeOfTwoIsToldAndTheOtherGoesOn) {
  const std::string good = (sample("photodiode_only") / "photodiode.csv").string();
  const std::string site_file = (sample("photodiode_only") / "site.yaml").string();
  for (const std::size_t column : {1U, 2U}) {
    const std::string dead = column == 1 ? "pd0" : "pd1";
    for (const auto& [value, fault] : {std::pair("0", " has the same value throughout"),
                                       std::pair("nan", " has no sample that can be used")}) {
      const std::string trace =
          with_column(good, column, [&](const std::string&) { return value; });
      expect_told(run({"--photodiode", trace, "--site", site_file}), 4,
                  {"trace.csv", (dead + fault).c_str(), "check its cable"});
      EXPECT_EQ(lines_of(speeds()), 3U) << "both vehicles still have a row\n" << speeds();
      EXPECT_EQ(speeds().find("delay"), std::string::npos) << speeds();
    }
  }
}

TEST_F(DeadSensor, APhotodiodeOfNothingButNoiseLeavesThePassesToTheOther) {
  Random random(4);
  const std::string trace = with_column(
      (sample("photodiode_only") / "photodiode.csv").string(), 1,
      [&](const std::string&) { return number_text(1e-8 + random.normal(0.0, 3e-10)); });
  const std::string site_file = (sample("photodiode_only") / "site.yaml").string();
  expect_told(run({"--photodiode", trace, "--site", site_file}), 0,
              {"trace.csv", "pd0 receives less than a hundredth", "check its cable"});
  EXPECT_EQ(lines_of(speeds()), 3U) << speeds();
  const Ran sound = run({"--photodiode", (sample("photodiode_only") / "photodiode.csv").string(),
                         "--site", site_file});
  EXPECT_EQ(sound.err.find("hundredth"), std::string::npos) << sound.err;
}

TEST_F(DeadSensor, ADeadPhotodiodeBesideACameraLeavesTheCamerasSpeeds) {
  const std::string clip = (sample("straight") / "clip.mp4").string();
  const std::string site_file = (sample("straight") / "site.yaml").string();
  ASSERT_EQ(run({clip, "--site", site_file}).code, 0);
  const std::string alone = speeds();
  const std::string trace = with_column((sample("straight") / "photodiode.csv").string(), 1,
                                        [](const std::string&) { return "1.5e-9"; });
  expect_told(run({clip, "--photodiode", trace, "--site", site_file}), 4,
              {"trace.csv", "pd0 has the same value throughout"});
  EXPECT_EQ(speeds(), alone);
}

TEST_F(DeadSensor, ABlackCameraBesideAPhotodiodeLeavesTheLight) {
  const std::string trace = (sample("straight") / "photodiode.csv").string();
  test::ClipSpec spec{.path = path("black.mkv"), .width_px = 960, .height_px = 540, .frames = 40};
  test::write_clip(spec, test::luma_painter([](int, int, int) { return 16; }));
  expect_told(run({spec.path.string(), "--photodiode", trace, "--site",
                   (sample("straight") / "site.yaml").string()}),
              4, {"black.mkv: no light in any of 40 frames", "photodiodes saw vehicles"});
  EXPECT_GE(lines_of(speeds()), 2U) << speeds();
  EXPECT_NE(speeds().find(",photodiode,"), std::string::npos) << speeds();
  EXPECT_EQ(speeds().find("camera"), std::string::npos) << speeds();
}

// Noise, a street lamp and a moving one; then black, for good or for a while, or the road alone.
TEST_F(DeadSensor, ACameraThatGoesBlackInTheMidstIsTold) {
  const std::string site_file = (sample("straight") / "site.yaml").string();
  enum class Then { black, black_for_a_while, black_at_once, empty_road };
  for (const Then then :
       {Then::black, Then::black_for_a_while, Then::black_at_once, Then::empty_road}) {
    test::ClipSpec spec{.path = path("fails.mkv"), .width_px = 960, .height_px = 540, .frames = 60};
    test::write_clip(spec, test::luma_painter([then](int frame, int u, int v) {
                       const int until = then == Then::black_for_a_while ? 45 : 60;
                       const int last = then == Then::black_at_once ? 3 : until;
                       const bool off = frame >= 20 && frame < std::min(until, 20 + last);
                       if (off && then != Then::empty_road) return 16;
                       if (!off && std::hypot(u - 300 - frame, v - 300) < 6.0) return 200;
                       return 17 + (u * 7 + v * 13 + frame * 5) % 3;
                     }));
    const bool told = then == Then::black || then == Then::black_for_a_while;
    const Ran ran = run({spec.path.string(), "--site", site_file});
    EXPECT_EQ(ran.code, told ? 4 : 0) << static_cast<int>(then);
    EXPECT_EQ(ran.err.find("the picture is black from 0.8") != std::string::npos, told) << ran.err;
    EXPECT_EQ(ran.err.find("to the clip's end") != std::string::npos, then == Then::black);
    EXPECT_NE(run_json().find(
                  told ? (then == Then::black ? "\"frames_black\": 40" : "\"frames_black\": 25")
                       : "\"frames_black\": 0"),
              std::string::npos)
        << static_cast<int>(then);
  }
}

class LateVehicle : public DeadSensor {
 protected:
  /// The sample's own vehicles are gone from the camera by 6 s; another one passes at 40 s.
  std::string trace() const {
    std::string text = bytes_of(sample("straight") / "photodiode.csv");
    Random random(6);
    for (int k = 10'000; k < 45'000; ++k) {
      const double time_s = 1e-3 * k, before_m = 15.0 * (40.0 - time_s);
      const double light_w = before_m > 0.0 ? 5e-5 / (before_m * before_m + 30.0) : 0.0;
      text += number_text(time_s) + "," + number_text(1e-9 + light_w + random.normal(0.0, 3e-10)) +
              "\n";
    }
    return write("trace.csv", text);
  }
  /// A street lamp, one frame a second.
  std::string lamp_clip(int frames) const {
    std::vector<std::int64_t> stamps_ms;
    for (int k = 0; k < frames; ++k) stamps_ms.push_back(1000 * k);
    test::ClipSpec spec{.path = path("lamp.mkv"),
                        .width_px = 960,
                        .height_px = 540,
                        .frames = frames,
                        .stamps_ms = stamps_ms};
    test::write_clip(spec, lamp());
    return spec.path.string();
  }
  static test::Painter lamp() {
    return test::luma_painter(
        [](int, int u, int v) { return std::hypot(u - 300, v - 100) < 6.0 ? 200 : 16; });
  }
  Ran run_beside(const std::string& clip_file) const {
    return run({clip_file, "--photodiode", trace(), "--site",
                (sample("straight") / "site.yaml").string()});
  }
};

TEST_F(LateVehicle, ThatTheCameraNeverSawIsCountedAndNamed) {
  expect_told(run_beside(lamp_clip(45)), 0,
              {"light as of a passing vehicle at 39.9", "the camera saw none near that time"});
  EXPECT_NE(run_json().find("passes_unseen_by_camera"), std::string::npos);
}

TEST_F(LateVehicle, AfterTheClipIsNamed) {
  expect_told(run_beside(lamp_clip(20)), 0,
              {"1 of the vehicles that passed the photodiodes did so before or after the clip",
               "a run of the trace alone measures them"});
  EXPECT_NE(run_json().find("\"passes_outside_clip\": 1"), std::string::npos) << run_json();
  EXPECT_EQ(lines_of(speeds()), 1U) << speeds();
}

TEST_F(LateVehicle, AfterAClipThatWasCutShortIsMeasuredByItsLight) {
  const test::ClipSpec spec{.path = path("cut.mp4"),
                            .encoder = "libx264",
                            .width_px = 960,
                            .height_px = 540,
                            .frames = 100,
                            .encoder_options = {{"qp", "0"}},
                            .muxer_options = {{"movflags", "+faststart"}}};
  test::write_clip(spec, lamp());
  std::filesystem::resize_file(spec.path, std::filesystem::file_size(spec.path) * 4 / 5);
  expect_told(run_beside(spec.path.string()), 4,
              {"ends early", "are measured by their light alone"});
  EXPECT_NE(speeds().find(",oncoming,,measured,36."), std::string::npos) << speeds();
}

TEST_F(DeadSensor, ASoundFileGivesWhatItsCsvGives) {
  std::string csv = "t_s,power_w\n";
  std::vector<float> values;
  Random random(9);
  for (int k = 0; k < 8000; ++k) {
    const double time_s = k / 1000.0, range_m = 15.0 * (5.0 - time_s);
    const double light_w = range_m > 0.0 ? 1e-5 * std::pow(std::hypot(range_m, 6.0), -2.0) : 0.0;
    values.push_back(static_cast<float>(light_w + random.normal(0.0, 1e-10)));
    csv += number_text(time_s) + "," + number_text(static_cast<double>(values.back())) + "\n";
  }
  SF_INFO info{};
  info.format = SF_FORMAT_WAV | SF_FORMAT_FLOAT;
  info.samplerate = 1000;
  info.channels = 1;
  SNDFILE* file = ::sf_open(path("trace.wav").c_str(), SFM_WRITE, &info);
  ASSERT_NE(file, nullptr);
  ::sf_write_float(file, values.data(), static_cast<sf_count_t>(values.size()));
  ::sf_close(file);
  const std::string site_file =
      write("roadside.yaml",
            "version: 1\nphotodiode: {position_m: [0, 0, 5], time_offset_s: 0,\n"
            "  volts_per_count: 1, transimpedance_v_per_a: 1, responsivity_a_per_w: 1}\n"
            "road:\n  kind: straight\n  lanes:\n"
            "    - {id: near, lateral_m: -3.4, width_m: 3.5, direction: oncoming}\n"
            "lamps: {height_m: 0.68}\n"
            "channel: {gain_db: -50, path_loss_exponent: 2, lamp_power_w: 1}\n");
  expect_told(run({"--photodiode", write("trace.csv", csv), "--site", site_file}), 0, {});
  const std::string expected = speeds();
  EXPECT_NE(expected.find("measured"), std::string::npos) << expected;
  expect_told(run({"--photodiode", path("trace.wav").string(), "--site", site_file}), 0, {});
  EXPECT_EQ(speeds(), expected);
}

}  // namespace
}  // namespace vildar
