#include <gtest/gtest.h>

#include "config/site_file.h"
#include "core/error.h"
#include "support/temporary_folder.h"

namespace vildar {
namespace {

constexpr const char* kMast =
    "version: 1\n"
    "photodiode: {position_m: [0, 0, 4]}\n";

TEST(Learned, IsReadAndWritten) {
  const TemporaryFolder folder;
  const Site site = load_site(folder.write(
      "site.yaml", std::string(kMast) +
                       "learned:\n"
                       "  mount:\n"
                       "    quantities:\n"
                       "    - {key: camera.yaw_deg, stated: {mean: -8.25, std: 1.0}, learned: -8}\n"
                       "    - {key: \"road.lanes.a: b.lateral_m\", stated: -4.0, learned: -4.1}\n"
                       "    clips: [\"00ff\", \"1e10\"]\n"));
  ASSERT_TRUE(site.learned.mount);
  EXPECT_FALSE(site.learned.photodiode);
  ASSERT_EQ(site.learned.mount->quantities.size(), 2U);
  EXPECT_EQ(site.learned.mount->quantities[0].key, "camera.yaw_deg");
  EXPECT_EQ(site.learned.mount->quantities[0].stated, (Uncertain{-8.25, 1.0}));
  EXPECT_EQ(site.learned.mount->quantities[1].key, "road.lanes.a: b.lateral_m");
  EXPECT_EQ(site.learned.mount->clips, (std::vector<std::string>{"00ff", "1e10"}));
  EXPECT_EQ(load_site(folder.write("again.yaml", effective_site_yaml(site))).learned, site.learned);
}

TEST(Learned, IsNotWrittenWhereNothingIs) {
  const TemporaryFolder folder;
  const Site site = load_site(folder.write("site.yaml", kMast));
  EXPECT_EQ(effective_site_yaml(site).find("learned"), std::string::npos);
}

TEST(Learned, FaultsAreTold) {
  const TemporaryFolder folder;
  try {
    load_site(folder.write("site.yaml", std::string(kMast) +
                                            "learned:\n  mount:\n    quantities:\n"
                                            "    - {key: camera.yaw_deg, stated: {mean: 1, "
                                            "std: -1}, learned: 1}\n"
                                            "    - {stated: 1, learned: 2}\n"
                                            "  photodiodes: {clips: []}\n"));
    FAIL() << "read";
  } catch (const ConfigError& error) {
    const std::string told = error.what();
    for (const char* word : {"learned.mount.quantities[0].stated", "learned.mount.quantities[1]",
                             "key", "learned.photodiodes", "did you mean"})
      EXPECT_NE(told.find(word), std::string::npos) << word << "\n" << told;
  }
}

}  // namespace
}  // namespace vildar
