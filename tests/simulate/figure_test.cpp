#include "simulate/figure.h"

#include <limits>

#include <gtest/gtest.h>

namespace vildar::simulate {
namespace {

Figure sample() {
  Figure figure;
  figure.name = "sample";
  figure.title = "A < B";
  figure.caption = "caption";
  figure.x_title = "time in s";
  figure.y_title = "error in %";
  figure.x_column = "t_s";
  figure.y_column = "error_percent";
  figure.series.push_back({"first, of two", {0.0, 1.0, 2.0}, {1.0, 10.0, 100.0}, 0});
  figure.series.push_back(
      {"second", {0.0, 1.0}, {std::numeric_limits<double>::quiet_NaN(), 5.0}, 1, true});
  return figure;
}

TEST(Figure, CsvHasOneRowPerPointAndEmptyCellsForGaps) {
  EXPECT_EQ(csv_of(sample()),
            "series,t_s,error_percent\n\"first, of two\",0,1\n\"first, of two\",1,10\n"
            "\"first, of two\",2,100\nsecond,0,\nsecond,1,5\n");
}

// The curve's points by arithmetic on the frame: x from 70 over 540, y from 46 over 360.
TEST(Figure, SvgPutsPointsWhereTheAxesSay) {
  Figure figure = sample();
  EXPECT_NE(svg_of(figure).find("M70.0 406.0L340.0 373.3L610.0 46.0"), std::string::npos);
  figure.log_y = true;
  EXPECT_NE(svg_of(figure).find("M70.0 406.0L340.0 226.0L610.0 46.0"), std::string::npos);
}

TEST(Figure, SvgNamesAxesAndSeriesAndEscapes) {
  const std::string svg = svg_of(sample());
  for (const char* text : {"time in s", "error in %", "first, of two", "second", "A &lt; B"})
    EXPECT_NE(svg.find(text), std::string::npos) << text;
  EXPECT_EQ(svg.find("nan"), std::string::npos);
}

TEST(Figure, NothingToDrawIsStillADrawing) {
  Figure figure = sample();
  figure.series.clear();
  EXPECT_NE(svg_of(figure).find("</svg>"), std::string::npos);
}

TEST(Page, HoldsFiguresTablesNumbersAndSettings) {
  Report report{"an-experiment", {sample()}, {{"t", "A table", "c", {"h"}, {{"cell"}}}}, {}};
  report.findings.push_back({"a number", 1.5, "deg"});
  const std::string page = page_of({report}, "seed=1");
  for (const char* text : {"an-experiment", "<svg", "A table", "cell", "1.500", "seed=1"})
    EXPECT_NE(page.find(text), std::string::npos) << text;
}

}  // namespace
}  // namespace vildar::simulate
