#include <cmath>
#include <functional>

#include "core/random.h"
#include "core/text.h"
#include "pipeline/broken.h"

namespace vildar {
namespace {

using test::expect_told;
using test::Ran;

struct Row {
  std::string t_s, power_w;
};

class BrokenTrace : public Broken {
 protected:
  /// Eight seconds at 500 Hz: dark with noise, and one vehicle that comes and is past at 5 s.
  static std::vector<Row> rows() {
    Random random(9);
    std::vector<Row> rows;
    for (int k = 0; k < 4000; ++k) {
      const double time_s = 0.002 * k, range_m = 15.0 * (5.0 - time_s);
      const double light_w = range_m > 0.0 ? 1e-5 * std::pow(std::hypot(range_m, 6.0), -2.0) : 0.0;
      rows.push_back({fixed_text(time_s, 3), number_text(light_w + random.normal(0.0, 1e-10))});
    }
    return rows;
  }
  static std::string text(const std::vector<Row>& rows, const std::string& end = "\n") {
    std::string text = "t_s,power_w" + end;
    for (const Row& row : rows) text += row.t_s + "," + row.power_w + end;
    return text;
  }
  std::string trace_site() const {
    return write("roadside.yaml",
                 "version: 1\nphotodiode: {position_m: [0, 0, 5], time_offset_s: 0}\n"
                 "road:\n  kind: straight\n  lanes:\n"
                 "    - {id: near, lateral_m: -3.4, width_m: 3.5, direction: oncoming}\n"
                 "lamps: {height_m: 0.68}\n"
                 "channel: {gain_db: -50, path_loss_exponent: 2, lamp_power_w: 1}\n");
  }
  /// The trace alone, without a clip.
  Ran run_trace(const std::string& content) const {
    return run({"--photodiode", write("trace.csv", content), "--site", trace_site()});
  }
  Ran run_beside_clip(const std::string& content) const {
    return run({clip({.path = path("clip.mkv")}), "--photodiode", write("trace.csv", content),
                "--site", site()});
  }
  std::string speeds() const { return test::bytes_of(out() / "speeds.csv"); }
};

TEST_F(BrokenTrace, WhatHoldsNoTraceIsThreeAloneAndFourBesideAClip) {
  const struct {
    std::string content;
    const char* fault;
  } cases[] = {
      {"", "the file is empty"},
      {"t_s,power_w\n", "no row that can be read after the header"},
      {"t_s,power_w\n0,1e-8\n", "1 of 1 samples can be used"},
      {"t_s,power_w\n0,nan\n1,nan\n", "0 of 2 samples can be used"},
      {"0,1e-8\n0.001,1e-8\n", "trace.csv:1: no header of a photodiode trace"},
      {"t_s;power_w\n0,0;1,0e-8\n", "columns that no commas part"},
      {"t_s,colour\n0,1\n", "no column of power, current, voltage or counts"},
      {"power_w\n1\n", "no column t_s"},
      {"t_s,pd7_power_w\n0,1\n1,1\n", "photodiode \"pd7\" is not in"},
      {"t_s,counts\n0,1\n1,1\n", "volts_per_count is missing"},
      {std::string("t_s,power_w\0\n0,1\n", 18), "binary data"},
      {"\xff\xfet\0_\0s\0", "UTF-16"},
  };
  for (const auto& [content, fault] : cases) {
    expect_told(run_trace(content), 3, {"trace.csv", fault});
    EXPECT_TRUE(test::files_in(out()).empty()) << fault;
    expect_told(run_beside_clip(content), 4,
                {"trace.csv", fault, "measuring with the camera alone"});
    EXPECT_EQ(test::files_in(out()), kOutputs) << fault;
    EXPECT_NE(run_json().find("camera alone"), std::string::npos);
    std::filesystem::remove_all(out());
  }
  expect_told(run({"--photodiode", path("missing.csv").string(), "--site", trace_site()}), 3,
              {"missing.csv", "no such file", "check the name"});
}

TEST_F(BrokenTrace, AGoodOneGivesASpeed) {
  expect_told(run_trace(text(rows())), 0, {});
  EXPECT_NE(speeds().find("measured"), std::string::npos) << speeds();
}

TEST_F(BrokenTrace, TheTimeOfEachStageIsToldOfATraceToo) {
  ASSERT_EQ(run_trace(text(rows())).code, 0);
  const std::string json = run_json();
  const std::size_t timings = json.find("\"timings_s\"");
  ASSERT_NE(timings, std::string::npos);
  for (const char* stage : {"\"estimate\": ", "\"read\": "})
    EXPECT_LT(json.find(stage, timings), json.find('}', timings)) << stage;
}

TEST_F(BrokenTrace, SamplesThatCannotBeUsedAreFourCountedAndNamed) {
  const struct {
    std::function<void(std::vector<Row>&)> spoil;
    const char* told;
  } cases[] = {
      {[](auto& all) {
         for (int k = 100; k < 150; ++k) all[k].power_w = "nan";
       },
       "50 samples of pd0 left out: not_a_number"},
      {[](auto& all) { all[7].power_w = "inf", all[8].power_w = "", all[9].power_w = "1e999"; },
       "3 samples of pd0 left out: not_a_number"},
      {[](auto& all) {
         for (int k = 100; k < 130; ++k) all[k].power_w = k % 2 == 0 ? "-2e-8" : "-3e-8";
       },
       "30 samples of pd0 left out: negative"},
      {[](auto& all) {
         for (int k = 500; k < 1000; ++k) all[k].power_w = all[499].power_w;
       },
       "501 samples of pd0 left out: stuck"},
      {[](auto& all) { std::swap(all[100], all[200]); }, "2 samples of pd0 left out: out_of_order"},
      {[](auto& all) { std::swap(all[100], all[200]); },
       "t_s goes from 0.4 to 0.202; where the logger's clock was set back"},
      {[](auto& all) {
         for (int k = 100; k < 110; ++k) all[k].t_s = all[99].t_s;
       },
       "10 samples of pd0 left out: repeated"},
      {[](auto& all) { all[100].t_s = "soon"; },
       "trace.csv:102: unreadable_time, the first of 1 rows"},
      {[](auto& all) { all[100].power_w = "1,2"; }, "trace.csv:102: wrong_cell_count"},
  };
  for (const auto& [spoil, told] : cases) {
    std::vector<Row> spoilt = rows();
    spoil(spoilt);
    expect_told(run_trace(text(spoilt)), 4, {"trace.csv", told});
    EXPECT_NE(speeds().find("measured"), std::string::npos) << told << "\n" << speeds();
  }
  const std::string whole = text(rows());
  expect_told(run_trace(whole.substr(0, whole.size() - 9)), 4,
              {"trace.csv:4001: cut_off_last_row"});
}

TEST_F(BrokenTrace, NegativePowerWithinNoiseIsNoise) {
  const Ran ran = run_trace(text(rows()));
  EXPECT_NE(text(rows()).find(",-"), std::string::npos) << "the trace goes below zero";
  expect_told(ran, 0, {});
  EXPECT_EQ(ran.err.find("left out"), std::string::npos) << ran.err;
}

TEST_F(BrokenTrace, AGapIsCountedAndNamedAndNoDamage) {
  std::vector<Row> all = rows();
  all.erase(all.begin() + 500, all.begin() + 1000);
  expect_told(run_trace(text(all)), 0,
              {"trace.csv: 1 gaps in pd0, the longest of 1.002 s after t_s = 0.998"});
  EXPECT_NE(run_json().find("\"gaps_pd0\": 1"), std::string::npos);
}

TEST_F(BrokenTrace, OtherWaysToWriteTheSameGiveTheSame) {
  ASSERT_EQ(run_trace(text(rows())).code, 0);
  const std::string expected = speeds();
  EXPECT_EQ(run_trace(text(rows(), "\r\n")).code, 0);
  EXPECT_EQ(speeds(), expected) << "CRLF";
  EXPECT_EQ(run_trace("\xef\xbb\xbf# of a logger\n\n" + text(rows())).code, 0);
  EXPECT_EQ(speeds(), expected) << "byte-order mark, comment and an empty line";
  std::string other = "note, power_w ,t_s\n";
  for (const Row& row : rows()) other += "x," + row.power_w + "," + row.t_s + "\n";
  expect_told(run_trace(other), 0, {"trace.csv:1: column \"note\" is not known; left out"});
  EXPECT_EQ(speeds(), expected) << "columns in another order, and one more";
}

TEST_F(BrokenTrace, ColumnsInAnyOrderGiveTheSameAndOneLeftOutIsNamed) {
  const std::string two =
      write("two.yaml",
            "version: 1\nphotodiodes:\n  - {id: a, position_m: [0, 0, 5]}\n"
            "  - {id: b, position_m: [2, 0, 5], time_offset_s: 0.5}\n"
            "road:\n  kind: straight\n  lanes:\n"
            "    - {id: near, lateral_m: -3.4, width_m: 3.5, direction: oncoming}\n"
            "lamps: {height_m: 0.68}\n"
            "channel: {gain_db: -50, path_loss_exponent: 2, lamp_power_w: 1}\n");
  const auto run_two = [&](const std::string& content) {
    return run({"--photodiode", write("trace.csv", content), "--site", two});
  };
  std::string ordered = "t_s,a_power_w,b_power_w\n", turned = "t_s,b_power_w,a_power_w\n",
              alone = "t_s,a_power_w\n";
  const std::vector<Row> all = rows();
  for (std::size_t k = 0; k < all.size(); ++k) {
    const std::string& other = all[(k + all.size() - 70) % all.size()].power_w;
    ordered += all[k].t_s + "," + all[k].power_w + "," + other + "\n";
    turned += all[k].t_s + "," + other + "," + all[k].power_w + "\n";
    alone += all[k].t_s + "," + all[k].power_w + "\n";
  }
  expect_told(run_two(ordered), 0,
              {"photodiodes[1].gain_ratio is not given; taken as 1 +- 0.05",
               "photodiodes[1].time_offset_s is not that of photodiodes[0].time_offset_s"});
  const std::string expected = speeds();
  EXPECT_EQ(run_json().find("lamp_power_w is not given"), std::string::npos);
  EXPECT_EQ(run_two(turned).code, 0);
  EXPECT_EQ(speeds(), expected);
  expect_told(run_two(alone), 0, {"has no column of photodiode b", "measuring without it"});
}

TEST_F(BrokenTrace, ALampPowerThatIsNotToldIsNamed) {
  const std::string site = write(
      "untold.yaml",
      "version: 1\nphotodiode: {position_m: [0, 0, 5]}\n"
      "road:\n  lanes:\n    - {id: near, lateral_m: -3.4, width_m: 3.5, direction: oncoming}\n"
      "lamps: {height_m: 0.68}\nchannel: {gain_db: -50, path_loss_exponent: 2}\n");
  expect_told(run({"--photodiode", write("trace.csv", text(rows())), "--site", site}), 0,
              {"channel.lamp_power_w is not given", "taken as 1 W", "measure it"});
}

TEST_F(BrokenTrace, ABeamThatNoMethodFollowsIsNamed) {
  const std::string site = write(
      "beam.yaml",
      "version: 1\nphotodiode: {position_m: [0, 0, 5], area_m2: 1e-4}\n"
      "road:\n  lanes:\n    - {id: near, lateral_m: -3.4, width_m: 3.5, direction: oncoming}\n"
      "lamps: {height_m: 0.68}\nchannel: {beam: low_beam, luminous_efficacy_lm_per_w: 300}\n");
  expect_told(run({"--photodiode", write("trace.csv", text(rows())), "--site", site}), 0,
              {"channel.beam: no method of a single photodiode follows a beam", "gain_db"});
}

TEST_F(BrokenTrace, StampsThatAreNoSecondsAreNamed) {
  std::vector<Row> all = rows();
  for (std::size_t k = 0; k < all.size(); ++k) all[k].t_s = std::to_string(2 * k);
  expect_told(run_trace(text(all)), 3,
              {"pd0 has 0.50000 samples a second by its stamps", "check that t_s is in seconds"});
  all.resize(500);
  for (std::size_t k = 0; k < all.size(); ++k)
    all[k].t_s = number_text(0.02 * static_cast<double>(k));
  expect_told(run_trace(text(all)), 0, {"pd0 has 50.0 samples a second by its stamps"});
}

TEST_F(BrokenTrace, LightThatGoesDownSaysSo) {
  std::vector<Row> all = rows();
  for (Row& row : all) row.power_w = number_text(1e-6 - std::stod(row.power_w));
  expect_told(run_trace(text(all)), 0, {"times as much as it rises", "if its amplifier inverts"});
  EXPECT_EQ(run_trace(text(rows())).err.find("inverts"), std::string::npos);
}

TEST_F(BrokenTrace, OneThatRunsBackwardsSaysSo) {
  std::vector<Row> all = rows();
  std::ranges::reverse(all);
  expect_told(
      run_trace(text(all)), 3,
      {"1 of 4000 samples can be used", "t_s goes back from row to row", "record the trace again"});
}

TEST_F(BrokenTrace, ATraceOfAnotherTimeThanTheClipIsFour) {
  std::vector<Row> late = rows();
  for (std::size_t k = 0; k < late.size(); ++k)
    late[k].t_s = fixed_text(1000.0 + 0.002 * static_cast<double>(k), 3);
  expect_told(run_beside_clip(text(late)), 4,
              {"trace.csv", "from 1000.000 to 1007.998 s", "the clip from 0 to",
               "nothing in common", "photodiodes[0].time_offset_s in", "site.yaml"});
  EXPECT_EQ(test::files_in(out()), kOutputs);
}

}  // namespace
}  // namespace vildar
