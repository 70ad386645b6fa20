#include "simulate/experiments.h"

#include <gtest/gtest.h>

namespace vildar::simulate {
namespace {

double finding(const Report& report, const std::string& what) {
  for (const Finding& one : report.findings)
    if (one.what == what) return one.value;
  ADD_FAILURE() << "no such number: " << what;
  return 0.0;
}

TEST(Experiments, EveryOneGivesWhatCanBeShown) {
  Options options;
  options.trials = 2;
  options.sample_period_s = 4e-3;
  for (const Experiment& experiment : experiments()) {
    const Report report = experiment.run(options);
    EXPECT_EQ(report.experiment, experiment.name);
    EXPECT_FALSE(report.figures.empty() && report.tables.empty()) << experiment.name;
    for (const Figure& figure : report.figures) {
      EXPECT_FALSE(figure.name.empty() || figure.caption.empty() || figure.x_title.empty() ||
                   figure.y_title.empty() || figure.x_column.empty() || figure.y_column.empty())
          << experiment.name;
      EXPECT_FALSE(figure.series.empty()) << figure.name;
    }
    for (const Table& table : report.tables)
      for (const auto& row : table.rows) EXPECT_EQ(row.size(), table.header.size()) << table.name;
  }
}

// Every number of every experiment, as it is written.
TEST(Experiments, NothingDependsOnTheNumberOfThreads) {
  const auto written = [](int threads) {
    Options options;
    options.trials = 5;
    options.sample_period_s = 4e-3;
    options.threads = threads;
    std::string text;
    for (const Experiment& experiment : experiments()) {
      const Report report = experiment.run(options);
      for (const Figure& figure : report.figures) text += figure.name + '\n' + csv_of(figure);
      for (const Table& table : report.tables) text += table.name + '\n' + csv_of(table);
      for (const Finding& found : report.findings)
        text += found.what + ' ' + std::to_string(found.value) + '\n';
    }
    return text;
  };
  const std::string alone = written(1);
  EXPECT_GT(alone.size(), 10'000u);
  EXPECT_TRUE(written(3) == alone);
}

TEST(Experiments, ChannelNumbers) {
  const Report report = path_loss(Options{});
  EXPECT_NEAR(finding(report, "order n of the half-power angle"), 2.60078, 5e-6);
  EXPECT_NEAR(finding(report, "gain C of the order n and 1 cm^2"), -42.42, 5e-3);
  EXPECT_NEAR(finding(report, "offset that gives the Lambertian pair"), 0.490, 0.001);
  EXPECT_NEAR(finding(report, "order n that gives the Lambertian pair"), 7.87, 0.01);
  EXPECT_NEAR(finding(report, "offset that gives the simulated pair"), 1.335, 0.001);
  EXPECT_NEAR(finding(report, "order n that gives the simulated pair"), 2.87, 0.01);
  const Report power = received_power(Options{});
  EXPECT_NEAR(finding(power, "incidence angle of the peak"), 30.1, 0.05);
  EXPECT_NEAR(finding(power, "range of the peak"), 0.863, 0.001);
}

TEST(Experiments, CurvedGeometryNeedsAnOffsetForThePublishedCurve) {
  const Report report = curved_geometry(Options{});
  EXPECT_NEAR(finding(report, "least incidence angle, d_o = 0.5 m"), 9.0, 0.05);
  EXPECT_GT(finding(report, "incidence angle at the end, d_o = 0.5 m"), 80.0);
  EXPECT_LT(finding(report, "incidence angle at the end, d_o = 0 m"), 1.0);
}

TEST(Options, NamesEveryViolation) {
  Options options;
  EXPECT_TRUE(options.problems().empty());
  options.trials = 0;
  options.duration_s = 5.0;
  options.half_power_angle_deg = 95.0;
  const auto problems = options.problems();
  ASSERT_EQ(problems.size(), 3u);
  EXPECT_EQ(problems[0], "trials = 0, must be 2 or more");
}

}  // namespace
}  // namespace vildar::simulate
