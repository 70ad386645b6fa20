#include "sink/report.h"

#include <set>

#include "sink/html.h"
#include "sink/support.h"
#include "sink/svg_axes.h"
#include "sink/svg_plots.h"
#include "sink/words.h"

namespace vildar {
namespace {

using test::Folder;
using test::measured_vehicle;
using test::withheld_vehicle;

bool contains(std::string_view text, std::string_view part) {
  return text.find(part) != std::string_view::npos;
}

std::size_t count(std::string_view text, std::string_view part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string_view::npos;
       at = text.find(part, at + part.size()))
    ++found;
  return found;
}

/// Opening and closing tags pair up in order, as a strict reader of the page needs.
std::string first_unbalanced_tag(std::string_view html) {
  const std::set<std::string> alone{"meta", "!DOCTYPE"};
  std::vector<std::string> open;
  for (std::size_t at = html.find('<'); at != std::string_view::npos; at = html.find('<', at + 1)) {
    const std::size_t end = html.find('>', at);
    if (end == std::string_view::npos) return "unfinished tag";
    const std::string_view tag = html.substr(at + 1, end - at - 1);
    if (tag.starts_with('/')) {
      if (open.empty() || open.back() != tag.substr(1)) return std::string(tag);
      open.pop_back();
    } else if (!tag.ends_with('/')) {
      const std::string name(tag.substr(0, tag.find(' ')));
      if (!alone.contains(name)) open.push_back(name);
    }
  }
  return open.empty() ? "" : open.back();
}

RunSummary summary() {
  RunSummary run;
  run.version = "0.1.0";
  run.inputs = {{"clip", "/clips/<night> & \"rain\".mp4", 12, std::string(64, 'a')}};
  run.clip = ClipSummary{"mp4", "h264", "yuv420p", 1920, 1080, 0, 30.0, 12.5};
  run.speed_limit_mps = 13.9;
  run.settings_yaml = "lanes: [{id: \"<near>\"}]\n";
  run.options = {{"site", "<script>alert(1)</script>"}};
  run.counts = {{"frames_read", 375}};
  run.rejected_samples = {{"pd0", {{"clipped", 7}}}};
  run.timings_s = {{"detect", 1.25}};
  run.warnings = {"line 3: <img src=x>"};
  return run;
}

TrackPlot plot_of(int track_id) {
  TrackPlot plot;
  plot.track_id = track_id;
  for (int i = 0; i < 50; ++i) {
    plot.t_s.push_back(1.25 + i * 0.065);
    plot.range_m.push_back(44.0 - 0.9 * i);
    plot.speed_mps.push_back(i == 20 ? NAN : 14.5);
    plot.azimuth_rad.push_back(-0.1 - 0.01 * i);
  }
  return plot;
}

TEST(Report, IsOneSelfContainedBalancedPage) {
  const std::vector<VehicleResult> vehicles{measured_vehicle(), withheld_vehicle()};
  const std::vector<TrackPlot> plots{plot_of(3), plot_of(4), plot_of(99)};
  const std::string html = report_text(summary(), vehicles, plots);
  EXPECT_TRUE(html.starts_with("<!DOCTYPE html>"));
  EXPECT_EQ(first_unbalanced_tag(html), "");
  for (const char* outside : {"http:", "https:", "src=", "@import", "url(", "<script", "<link"})
    EXPECT_EQ(count(html, outside), outside == std::string_view("src=") ? 1u : 0u)
        << outside;  // in the escaped warning
}

TEST(Report, EscapesEverythingThatComesFromInputs) {
  VehicleResult vehicle = measured_vehicle();
  vehicle.lane = "<near & \"dear\">";
  vehicle.warnings = {"<u>"};
  vehicle.methods[0].k_source = "<k>";
  const std::string html = report_text(summary(), std::vector<VehicleResult>{vehicle}, {});
  for (const char* raw : {"<night>", "<near", "<script>", "<img", "<u>", "<k>"})
    EXPECT_FALSE(contains(html, raw)) << raw;
  EXPECT_TRUE(contains(html, "&lt;night&gt; &amp; &quot;rain&quot;.mp4"));
  EXPECT_TRUE(contains(html, "&lt;near &amp; &quot;dear&quot;&gt;"));
}

TEST(Report, SaysSpeedsInKilometresPerHourWithTheirUncertainty) {
  // 14.5 m/s is 52.2 km/h, 0.2 m/s is 0.72 km/h; 14.108 and 14.892 m/s are 50.8 and 53.6 km/h.
  const std::string html =
      report_text(summary(), std::vector<VehicleResult>{measured_vehicle()}, {});
  EXPECT_TRUE(contains(html, "52.2 ± 0.7"));
  EXPECT_TRUE(contains(html, "50.8 to 53.6"));
}

TEST(Report, WithheldVehicleGivesTheReasonInWordsAndNoSpeed) {
  VehicleResult vehicle = withheld_vehicle();
  vehicle.speed.speed_mps = 33.0;  // what is withheld must not leak: 118.8 km/h
  vehicle.speed.time_s = 5.1;
  const std::string html = report_text(summary(), std::vector<VehicleResult>{vehicle},
                                       std::vector<TrackPlot>{plot_of(4)});
  EXPECT_TRUE(contains(html, sentence_for(Miss::too_short)));
  EXPECT_FALSE(contains(html, "118.8"));
  EXPECT_FALSE(contains(html, "class=\"histogram\""));
  EXPECT_FALSE(contains(html, "class=\"mark\""));
}

TEST(Report, CountsOnlySpeedsThatAreSurelyAboveTheLimit) {
  RunSummary run = summary();
  const auto over = [&](double limit_mps) {
    run.speed_limit_mps = limit_mps;
    return contains(report_text(run, std::vector<VehicleResult>{measured_vehicle()}, {}),
                    "<b>1</b><span>above");
  };
  EXPECT_TRUE(over(14.0));    // below the interval, which starts at 14.108 m/s
  EXPECT_FALSE(over(14.25));  // inside it
}

TEST(Report, EmptyRunAndManyVehiclesArePagesToo) {
  const std::string empty = report_text({}, {}, {});
  EXPECT_EQ(first_unbalanced_tag(empty), "");
  EXPECT_TRUE(contains(empty, "No vehicle was seen"));
  std::vector<VehicleResult> vehicles;
  for (int i = 1; i <= 60; ++i) {
    vehicles.push_back(measured_vehicle());
    vehicles.back().track_id = i;
    vehicles.back().speed.speed_mps += 0.1 * i;
  }
  const std::string many = report_text(summary(), vehicles, {});
  EXPECT_EQ(first_unbalanced_tag(many), "");
  EXPECT_EQ(count(many, "<details id=\"vehicle-"), 60u);
  EXPECT_FALSE(contains(many, "<details id=\"vehicle-1\" open"));
}

TEST(Report, IsWritten) {
  const Folder folder;
  write_report(folder / "report.html", summary(), {}, {}).commit();
  EXPECT_EQ(test::text_of(folder / "report.html"), report_text(summary(), {}, {}));
}

TEST(Words, EveryReasonHasASentenceOfItsOwn) {
  std::set<std::string_view> sentences;
  for (int i = 0; i <= static_cast<int>(Miss::not_on_road); ++i) {
    const std::string_view sentence = sentence_for(static_cast<Miss>(i));
    EXPECT_TRUE(sentence.ends_with('.')) << sentence;
    EXPECT_NE(sentence, "No reason is recorded.") << i;
    sentences.insert(sentence);
  }
  EXPECT_EQ(sentences.size(), static_cast<std::size_t>(Miss::not_on_road) + 1);
}

TEST(Ticks, AreRoundNumbersInsideTheRange) {
  const Ticks ticks = nice_ticks(0.0, 53.0, 5);
  EXPECT_EQ(ticks.at, (std::vector<double>{0, 10, 20, 30, 40, 50}));
  EXPECT_EQ(ticks.digits, 0);
  const Ticks fine = nice_ticks(-0.031, 0.012, 4);
  EXPECT_DOUBLE_EQ(fine.step, 0.01);
  EXPECT_EQ(fine.digits, 2);
  EXPECT_EQ(fine.at.size(), 5u);  // -0.03 to 0.01
}

TEST(TimePlot, ValuesThatDifferByRoundingAloneAreAFlatLine) {
  std::vector<double> t_s(50), values(50, 50.0);
  for (std::size_t i = 0; i < t_s.size(); ++i) t_s[i] = static_cast<double>(i);
  values.back() = std::nextafter(50.0, 51.0);
  EXPECT_LT(svg_time_plot({"range in m", t_s, values, {}, false}).size(), 10'000u);
  EXPECT_LE(nice_ticks(50.0, std::nextafter(50.0, 51.0), 5).at.size(), 12u);
}

TEST(TimePlot, GapsLiftThePenAndHopelessSeriesGiveNothing) {
  const std::vector<double> t_s{0.0, 1.0, 2.0, 3.0, 4.0};
  const std::string svg = svg_time_plot({"range in m", t_s, {5.0, 4.0, NAN, 2.0, 1.0}, {}, false});
  EXPECT_EQ(count(svg.substr(svg.find("d=\"")), "M"), 2u);
  EXPECT_EQ(svg_time_plot({"range in m", t_s, {}, {}, false}), "");
  EXPECT_EQ(svg_time_plot({"range in m", t_s, {NAN, NAN, NAN, NAN, 1.0}, {}, false}), "");
  const std::string flat = svg_time_plot({"range in m", t_s, {3.0, 3.0, 3.0, 3.0, 3.0}, {}, false});
  EXPECT_FALSE(flat.empty());
  EXPECT_FALSE(contains(flat, "nan"));
}

TEST(Histogram, BarsHoldAsManyVehiclesAsThereAre) {
  // The heights of the bars, as counts, add up to the vehicles whose intervals lie inside.
  std::vector<VehicleResult> vehicles(5, measured_vehicle());
  for (std::size_t i = 0; i < vehicles.size(); ++i) {
    SpeedEstimate& speed = vehicles[i].speed;
    speed.speed_mps += static_cast<double>(i);
    speed.lo95_mps += static_cast<double>(i);
    speed.hi95_mps += static_cast<double>(i);
  }
  vehicles.push_back(withheld_vehicle());
  const std::string svg = svg_speed_histogram(vehicles, 13.9);
  double height_sum = 0.0;
  for (std::size_t at = svg.find("<rect class=\"oncoming\""); at != std::string::npos;
       at = svg.find("<rect class=\"oncoming\"", at + 1)) {
    if (svg.compare(svg.find("width=", at), 10, "width=\"12\"") == 0 &&
        svg.compare(svg.find("y=\"", at), 5, "y=\"8\"") == 0)
      continue;  // the legend's
    height_sum += std::stod(svg.substr(svg.find("height=\"", at) + 8));
  }
  // The grid line of count 1 tells how high one vehicle is.
  const auto y_of = [&](std::string_view tick) {
    const std::size_t end = svg.find("text-anchor=\"end\">" + std::string(tick) + "<");
    const std::size_t at = svg.rfind("y=\"", end);
    return std::stod(svg.substr(at + 3));
  };
  const double one = y_of("0") - y_of("1");
  constexpr double kRounding = 0.05 * 20;  // a tenth of a unit per bar edge
  EXPECT_NEAR(height_sum, 5.0 * one, kRounding + 0.02 * one);
  EXPECT_EQ(svg_speed_histogram(std::vector<VehicleResult>{withheld_vehicle()}, {}), "");
}

TEST(Histogram, SpeedWithoutSpreadStandsInOneBar) {
  VehicleResult vehicle = measured_vehicle();
  vehicle.speed.std_mps = 0.0;
  vehicle.speed.lo95_mps = vehicle.speed.hi95_mps = vehicle.speed.speed_mps;
  const std::string svg = svg_speed_histogram(std::vector<VehicleResult>{vehicle}, {});
  EXPECT_EQ(count(svg, "<rect class=\"oncoming\""), 2u);  // the bar and the legend
}

}  // namespace
}  // namespace vildar
