#include "detect/combing.h"

#include <gtest/gtest.h>

#include <vector>

#include "detect/scene.h"

namespace vildar {
namespace {

constexpr int kSide_px = 48;
constexpr double kNoise_codes = 2.0;

// Lamps in turn, each a spot whose even and odd rows are drawn `apart_px` beside each other, and
// that leans by `lean` columns per row, `reach_px` high to either side.
Combing lamps(double apart_px, double lean, double reach_px = 3.0, double strength = 5.0) {
  constexpr double kSpread_px = 1.0;
  Combing combing;
  Random random(3);
  for (int lamp = 0; lamp < 200; ++lamp) {
    const double middle = 23.0 + random.uniform(0.0, 2.0);
    scene::Picture even(kSide_px, kSide_px), odd(kSide_px, kSide_px), both(kSide_px, kSide_px);
    for (double part = -reach_px; part <= reach_px; part += 0.5) {
      const double u = middle + lean * part, v = middle + part;
      even.add_gaussian(u, v, kSpread_px, strength);
      odd.add_gaussian(u + apart_px, v, kSpread_px, strength);
    }
    for (int v = 0; v < kSide_px; ++v)
      for (int u = 0; u < kSide_px; ++u) both.at(u, v) = (v % 2 == 0 ? even : odd).at(u, v);
    Frame frame = both.frame(Response(), 8, 16, 235, 235, kNoise_codes, lamp + 1);
    frame.index = 4 * lamp;
    Blob blob;
    blob.box = {4, 4, kSide_px - 5, kSide_px - 5};
    combing.add(frame, std::vector{blob});
  }
  return combing;
}

TEST(Combing, IsToldOfRowsThatStandBesideTheNext) {
  for (const double apart_px : {-4.0, -1.0, 1.0, 4.0}) {
    const Combing told = lamps(apart_px, 0.0);
    EXPECT_EQ(told.judged(), 200);
    EXPECT_TRUE(told.told()) << apart_px << " px: " << told.combed();
  }
}

TEST(Combing, IsNotToldOfWholePictures) {
  for (const double lean : {0.0, 0.5, -1.0}) {
    const Combing told = lamps(0.0, lean);
    EXPECT_EQ(told.judged(), 200);
    EXPECT_EQ(told.combed(), 0) << "leaning by " << lean;
    EXPECT_FALSE(told.told());
  }
  EXPECT_EQ(lamps(2.0, 0.0, 0.0).judged(), 0) << "of lamps with few rows";
  EXPECT_EQ(lamps(2.0, 0.0, 6.0, 0.01).judged(), 0) << "of what coding left of faint light";
}

}  // namespace
}  // namespace vildar
