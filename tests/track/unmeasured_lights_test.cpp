#include "track/unmeasured_lights.h"

#include <gtest/gtest.h>

#include "one_car.h"

namespace vildar {
namespace {

// A light whose outline is square, of a width in metres, and clips to a share of that.
TrackCounts counts_of(double width_m, double clipped_share, Verdict verdict, bool stays = false) {
  const scene::OneCar road;
  Lamp lamp = road.lamp(0, 60, -4.0);
  for (LampRecord& record : lamp.records) {
    const LampRecord& at = stays ? lamp.records.back() : record;
    const double inverse_depth_per_m = road.view.place(at.at_px).inverse_depth_per_m;
    const double width_px = width_m * inverse_depth_per_m * road.view.focal_px();
    record.sighting.box = {0, 0, static_cast<int>(width_px), static_cast<int>(width_px)};
    record.sighting.saturated_px = static_cast<int>(clipped_share * width_px * width_px);
  }
  TrackCounts counts;
  count_unmeasured(lamp, verdict, road.view, counts);
  return counts;
}

TEST(UnmeasuredLights, OneClippedAreaInPlaceOfAVehiclesLampsIsCounted) {
  EXPECT_EQ(counts_of(2.5, 0.78, Verdict::undecided).saturated, 1);        // a disc
  EXPECT_EQ(counts_of(2.5, 0.1, Verdict::undecided).saturated, 0);         // a lamp in its halo
  EXPECT_EQ(counts_of(2.5, 0.78, Verdict::undecided, true).saturated, 0);  // a lit window
  EXPECT_EQ(counts_of(0.5, 0.78, Verdict::undecided).saturated, 0);
  EXPECT_EQ(counts_of(2.5, 0.78, Verdict::vehicle).saturated, 0);
  EXPECT_EQ(counts_of(2.5, 0.78, Verdict::reflection).saturated, 0);
  EXPECT_EQ(counts_of(2.5, 0.78, Verdict::static_light).saturated, 0);
}

}  // namespace
}  // namespace vildar
