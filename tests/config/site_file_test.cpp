#include "config/site_file.h"

#include <gtest/gtest.h>

#include "config/site_text.h"
#include "support/temporary_folder.h"

namespace vildar {
namespace {

TEST(SiteFile, TheContractsExampleIsRead) {
  const TemporaryFolder folder;
  const Site site = load_site(folder.write("site.yaml", kContractSite));
  ASSERT_TRUE(site.camera);
  EXPECT_EQ(site.camera->width_px, 1920);
  EXPECT_EQ(site.camera->height_px, 1080);
  EXPECT_EQ(site.camera->focal_px, (std::array<double, 2>{1400.0, 1400.0}));
}

}  // namespace
}  // namespace vildar
