#include "config/lamp_classes.h"

#include <cmath>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "config/site_file.h"
#include "config/site_text.h"
#include "support/temporary_folder.h"

namespace vildar {
namespace {

constexpr std::string_view kOnePopulation =
    "  height_m: {mean: 0.68, std: 0.08}\n  separation_m: {mean: 1.25, std: 0.12}\n";

TEST(LampClasses, ArePooledByTheirShares) {
  const TemporaryFolder folder;
  const std::string classes =
      "  classes:\n"
      "    - {id: car, share: 3, height_m: {mean: 0.6, std: 0.1}, separation_m: 1.2}\n"
      "    - {id: motorcycle, height_m: {mean: 0.8, std: 0.1}}\n";
  const Site site =
      load_site(folder.write("site.yaml", with(kContractSite, kOnePopulation, classes)));
  ASSERT_EQ(site.lamps.classes.size(), 2u);
  EXPECT_EQ(site.lamps.classes[0],
            (LampClass{"car", 3.0, Uncertain{0.6, 0.1}, Uncertain{1.2, 0.0}}));
  EXPECT_EQ(site.lamps.classes[1], (LampClass{"motorcycle", 1.0, Uncertain{0.8, 0.1}, {}}));
  // Three quarters at 0.6, one at 0.8: variance 0.1^2 + 3 / 16 * 0.2^2.
  EXPECT_DOUBLE_EQ(site.lamps.height_m->mean, 0.65);
  EXPECT_NEAR(site.lamps.height_m->std, std::sqrt(0.01 + 0.0075), 1e-12);
  EXPECT_DOUBLE_EQ(site.lamps.separation_m->mean, 1.2);
  EXPECT_EQ(load_site(folder.write("again.yaml", effective_site_yaml(site))).lamps, site.lamps);
}

TEST(LampClasses, MayGiveTheirTailLamps) {
  const TemporaryFolder folder;
  const std::string classes =
      "  classes:\n"
      "    - {id: car, height_m: 0.7, separation_m: 1.2}\n"
      "    - {id: lorry, height_m: 0.9, separation_m: 2, tail_height_m: {mean: 1, std: 0.15},\n"
      "       tail_separation_m: {mean: 2.05, std: 0.15}}\n";
  const Site site =
      load_site(folder.write("site.yaml", with(kContractSite, kOnePopulation, classes)));
  ASSERT_EQ(site.lamps.classes.size(), 2U);
  EXPECT_FALSE(site.lamps.classes[0].tail_height_m);
  EXPECT_FALSE(site.lamps.classes[0].tail_separation_m);
  EXPECT_EQ(site.lamps.classes[1].tail_height_m, (Uncertain{1.0, 0.15}));
  EXPECT_EQ(site.lamps.classes[1].tail_separation_m, (Uncertain{2.05, 0.15}));
  EXPECT_TRUE(site.lamps.classes_tell_tails());
  EXPECT_EQ(load_site(folder.write("again.yaml", effective_site_yaml(site))).lamps, site.lamps);
}

TEST(LampClasses, StandAlone) {
  const TemporaryFolder folder;
  const std::string both = std::string(kOnePopulation) + "  classes: [{id: car, height_m: 0.7}]\n";
  try {
    load_site(folder.write("site.yaml", with(kContractSite, kOnePopulation, both)));
    FAIL() << "both populations were read";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("lamps.height_m"), std::string::npos) << error.what();
  }
}

TEST(LampClasses, AListOfNoneIsAFault) {
  const TemporaryFolder folder;
  try {
    load_site(folder.write("site.yaml", with(kContractSite, kOnePopulation, "  classes: []\n")));
    FAIL() << "no class was read as lamps";
  } catch (const ConfigError& error) {
    ASSERT_EQ(error.problems().size(), 1u);
    EXPECT_EQ(error.problems()[0].key, "lamps.classes");
  }
}

}  // namespace
}  // namespace vildar
