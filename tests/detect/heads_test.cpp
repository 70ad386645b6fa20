#include "detect/heads.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace vildar {
namespace {

std::vector<PixelRun> runs_of(const std::vector<std::string>& picture) {
  std::vector<PixelRun> runs;
  for (int v = 0; v < static_cast<int>(picture.size()); ++v)
    for (int u = 0; u < static_cast<int>(picture[v].size()); ++u) {
      if (picture[v][u] != '#') continue;
      if (!runs.empty() && runs.back().v == v && runs.back().u_end == u)
        ++runs.back().u_end;
      else
        runs.push_back({v, u, u + 1});
    }
  return runs;
}

/// The picture with what is cut as '-'.
std::vector<std::string> cut(std::vector<std::string> picture) {
  const std::vector<PixelRun> runs = runs_of(picture);
  HeadFinder finder;
  for (const PixelRun& run : finder.cuts(runs))
    for (int u = run.u_begin; u < run.u_end; ++u) picture[run.v][u] = '-';
  return picture;
}

TEST(Heads, LampsAreCutOffTheLightThatTheyStandOn) {
  EXPECT_EQ(cut({".###......###.",     //
                 "#####....#####",     //
                 "#####....#####",     //
                 "#####....#####",     //
                 ".###......###.",     //
                 ".##############",    //
                 ".##############"}),  //
            (std::vector<std::string>{".###......###.", "#####....#####", "#####....#####",
                                      "#####....#####", ".###......###.", ".----####-----#",
                                      ".##############"}));
}

TEST(Heads, ALampAloneIsCutWhereWhatIsBelowIsTwiceAsWide) {
  const std::vector<std::string> lamp{"..####......", ".######.....", ".######.....",
                                      ".######.....", "..####......", "...##.......",
                                      "...##......."};
  EXPECT_EQ(cut(lamp), lamp);  // on its own narrow image on the road
  std::vector<std::string> with_patch = lamp;
  with_patch.push_back("############");
  with_patch.push_back("############");
  std::vector<std::string> parted = with_patch;
  parted[7] = "##----######";
  EXPECT_EQ(cut(with_patch), parted);
}

TEST(Heads, DiscsThatRunTogetherAreLeftWhole) {
  const std::vector<std::string> beside{"..##....##..", ".####..####.", "############",
                                        "############", ".####..####.", "..##....##.."};
  EXPECT_EQ(cut(beside), beside);
  const std::vector<std::string> aslant{"..###.......", ".#####......", "#######.....",
                                        "#######.##..", "############", ".###########",
                                        "..###.#####.", ".......###.."};
  EXPECT_EQ(cut(aslant), aslant);
}

TEST(Heads, SpecksAndNotchesOnTopAreNoLamps) {
  const std::vector<std::string> ragged{"..#....##...", "..#..#.##.#.", ".##########.",
                                        "############", "############"};
  EXPECT_EQ(cut(ragged), ragged);
}

}  // namespace
}  // namespace vildar
