#include "config/ego_trace.h"

#include <string_view>

#include <gtest/gtest.h>

#include "config/site_text.h"
#include "support/temporary_folder.h"

namespace vildar {
namespace {

TEST(EgoTrace, IsReadBesideTheSite) {
  const TemporaryFolder folder;
  const auto site =
      folder.write("site.yaml", with(kContractSite, "speed_mps: 0.0  ", "trace: ego.csv  "));
  folder.write("ego.csv",
               "# the car's own log\nt_s,speed_mps,yaw_rate_rad_per_s\n\n0.0,10,0.01\r\n"
               "0.5, 10.5 ,-0.02\n");
  const EgoSite ego = *load_site(site).ego;
  EXPECT_EQ(ego.trace_path, folder.path() / "ego.csv");
  ASSERT_EQ(ego.trace.size(), 2u);
  EXPECT_EQ(ego.trace[0], (EgoSample{0.0, 10.0, 0.01}));
  EXPECT_EQ(ego.trace[1], (EgoSample{0.5, 10.5, -0.02}));

  const auto fault_of = [&](std::string_view trace) {
    folder.write("ego.csv", trace);
    const auto problems = problems_of(site);
    EXPECT_FALSE(problems.empty()) << trace;
    return problems.empty() ? std::string() : problems[0].fault;
  };
  const std::string header = "t_s,speed_mps\n";
  const std::string place = (folder.path() / "ego.csv").string() + ":";
  for (const auto& [trace, line] :
       std::vector<std::pair<std::string, std::string>>{{"time,speed\n0,1\n", "1"},
                                                        {"t_s\n0\n", "1"},
                                                        {header + "0,1\n0.5\n", "3"},
                                                        {header + "0,1\n0.5,nan\n", "3"},
                                                        {header + "0,1\n0.5,1x\n", "3"},
                                                        {header + "0,1\n0.5,-1\n", "3"},
                                                        {header + "0,1\n0,1\n", "3"},
                                                        {header + "0,1\n1,1\n0.5,1\n", "4"}})
    EXPECT_NE(fault_of(trace).find(place + line + ":"), std::string::npos) << trace;
  // Kilometres an hour, braking by 3 m/s^2; degrees a second.
  EXPECT_NE(fault_of(header + "0,180\n").find("out of range"), std::string::npos);
  EXPECT_NE(
      fault_of(header + "0,60\n0.7,52.4\n1.4,44.9\n2.1,37.3\n2.8,29.8\n").find("than tyres give"),
      std::string::npos);
  // A spike, and samples far apart.
  EXPECT_NE(fault_of(header + "0,16\n0.1,16\n0.2,54\n0.3,16\n").find(place + "4:"),
            std::string::npos);
  EXPECT_NE(fault_of(header + "0,57.6\n5,0\n10,90\n").find("than tyres give"), std::string::npos);
  EXPECT_NE(fault_of("t_s,speed_mps,yaw_rate_rad_per_s\n0,15,2\n").find("degrees"),
            std::string::npos);
  EXPECT_NE(fault_of("").find("no header"), std::string::npos);
  EXPECT_NE(fault_of(header).find("no samples"), std::string::npos);
  std::filesystem::remove(folder.path() / "ego.csv");
  EXPECT_NE(problems_of(site).at(0).fault.find("does not exist"), std::string::npos);
  EXPECT_EQ(problems_of(site).at(0).key, "ego.trace");
}

TEST(EgoTrace, NoiseOfOneThatStandsCountsAsZero) {
  const TemporaryFolder folder;
  const auto site =
      folder.write("site.yaml", with(kContractSite, "speed_mps: 0.0  ", "trace: ego.csv  "));
  folder.write("ego.csv", "t_s,speed_mps\n0,-0.05\n0.5,0.04\n1,-0.3\n");
  const EgoSite ego = *load_site(site).ego;
  ASSERT_EQ(ego.trace.size(), 3u);
  EXPECT_EQ(ego.trace[0].speed_mps, 0.0);
  EXPECT_EQ(ego.trace[1].speed_mps, 0.04);
  EXPECT_EQ(ego.trace[2].speed_mps, 0.0);
}

TEST(EgoTrace, ASpeedBesideATraceIsRefused) {
  const TemporaryFolder folder;
  folder.write("ego.csv", "t_s,speed_mps\n0,1\n");
  const auto problems = problems_of(folder.write(
      "site.yaml", with(kContractSite, "speed_mps: 0.0  ", "speed_mps: 0.0\n  trace: ego.csv")));
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_EQ(problems[0].key, "ego.trace");
}

}  // namespace
}  // namespace vildar
