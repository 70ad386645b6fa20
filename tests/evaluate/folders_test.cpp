#include "evaluate/folders.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "support/temporary_folder.h"

namespace vildar {
namespace {

constexpr char kSpeeds[] =
    "track_id,direction,lane,status,t_first_s,t_last_s,t_ref_s,speed_mps,speed_std_mps,"
    "speed_lo95_mps,speed_hi95_mps,range_ref_m\n"
    "4,oncoming,near,measured,0.5,2.5,1.5,20.5,0.4,19.7,21.3,35\n"
    "7,receding,,withheld:no_scale,1,2,,,,,,\n";

TEST(RunFolder, ReadsWhatARunWrote) {
  const TemporaryFolder folder;
  folder.write("speeds.csv", kSpeeds);
  folder.write("tracks.csv",
               "track_id,frame,t_s,u_left_px,v_left_px,u_right_px,v_right_px,azimuth_rad,range_m\n"
               "4,16,0.53,110,50,140,51,-0.1,60\n"
               "4,15,0.5,,,141,51,,\n");
  folder.write("methods.csv",
               "track_id,method,status,t_ref_s,speed_mps,speed_std_mps\n"
               "4,fused,measured,1.5,20.5,0.4\n"
               "4,power_slope_camera,withheld:saturated,,,\n");
  const RunFolder run = read_run_folder(folder.path());
  EXPECT_TRUE(run.notes.empty());
  ASSERT_EQ(run.vehicles.size(), 2U);
  const RunVehicle& first = run.vehicles[0];
  EXPECT_EQ(first.track_id, "4");
  ASSERT_TRUE(first.outcome.speed);
  EXPECT_EQ(first.outcome.speed->speed_mps, 20.5);
  EXPECT_EQ(first.outcome.speed->hi95_mps, 21.3);
  EXPECT_EQ(first.range_ref_m, 35.0);
  ASSERT_EQ(first.sightings.size(), 2U);
  EXPECT_EQ(first.sightings[0].frame, 15);
  EXPECT_FALSE(first.sightings[0].lamps.left_px);
  EXPECT_EQ(first.sightings[1].azimuth_rad, -0.1);
  ASSERT_EQ(first.methods.size(), 2U);
  EXPECT_EQ(first.methods[1].outcome.withheld, "saturated");
  EXPECT_EQ(run.vehicles[1].outcome.withheld, "no_scale");
}

TEST(RunFolder, SaysWhatIsAbsentAndTakesTracksWithoutASpeedRow) {
  const TemporaryFolder folder;
  folder.write("speeds.csv", kSpeeds);
  EXPECT_EQ(read_run_folder(folder.path()).notes.size(), 2U);
  folder.write("tracks.csv",
               "track_id,frame,t_s,u_left_px,v_left_px,u_right_px,v_right_px\n"
               "9,3,0.3,1,2,3,2\n9,1,0.1,1,2,3,2\n");
  const RunFolder run = read_run_folder(folder.path());
  ASSERT_EQ(run.vehicles.size(), 3U);
  EXPECT_EQ(run.vehicles[2].outcome.withheld, "not_in_speeds_csv");
  EXPECT_EQ(run.vehicles[2].t_first_s, 0.1);
  EXPECT_EQ(run.vehicles[2].t_last_s, 0.3);
}

TEST(RunFolder, RefusesRowsThatContradictTheContract) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::string& row, const std::string& part) {
    folder.write(
        "speeds.csv",
        "track_id,status,t_first_s,t_last_s,t_ref_s,speed_mps,speed_std_mps,speed_lo95_mps,"
        "speed_hi95_mps\n" +
            row + "\n");
    try {
      read_run_folder(folder.path());
      ADD_FAILURE() << row << " was accepted";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
  };
  refused("1,fine,0,1,0.5,20,1,,", "\"fine\" is not a status");
  refused("1,measured,0,1,0.5,,1,,", ":2: column speed_mps: is empty");
  refused("1,measured,0,1,0.5,20,0,,", "must be positive");
  refused("1,measured,0,1,0.5,-20,1,,", "column speed_mps: is negative");
  refused("1,measured,0,1,0.5,20,1,22,18", "column speed_hi95_mps: is below speed_lo95_mps");
  refused("1,measured,2,1,0.5,20,1,,", "is before t_first_s");
  refused("1,measured,0,1,0.5,20,1,,\n1,withheld:x,0,1,,,,,",
          ":3: column track_id: 1 stands in an earlier");
  folder.write("speeds.csv", kSpeeds);
  folder.write("methods.csv", "track_id,method,status,t_ref_s,speed_mps\n5,fused,measured,1,20\n");
  EXPECT_THROW(read_run_folder(folder.path()), InputError);
}

class TruthFolder : public testing::Test {
 protected:
  std::vector<TruthVehicle> read(const std::string& vehicles, const std::string& tracks) const {
    folder_.write("truth_vehicles.csv",
                  "vehicle_id,t_ref_s,speed_mps,acceleration_mps2\n" + vehicles);
    folder_.write(
        "truth_tracks.csv",
        "frame,t_s,vehicle_id,u_left_px,v_left_px,u_right_px,v_right_px,range_m,speed_mps,"
        "occluded\n" +
            tracks);
    return read_truth_folder(folder_.path());
  }
  TemporaryFolder folder_;
};

TEST_F(TruthFolder, SpeedIsInterpolatedWhereTracksReachAndExtrapolatedBeyond) {
  // The tracks say 20 to 22 m/s; the reference, which they contradict on purpose, tells which is
  // used.
  const auto truth = read("car,1.0,30,2\nvan,1.0,15,\n",
                          "0,0.0,car,,,,,100,20,0\n"
                          "1,1.0,car,1,2,3,4,80,,1\n"
                          "2,2.0,car,,,,,60,22,0\n");
  ASSERT_EQ(truth.size(), 2U);
  EXPECT_NEAR(*truth[0].speed_at(0.5), 20.5, 1e-12);
  EXPECT_NEAR(*truth[0].speed_at(2.0), 22.0, 1e-12);
  EXPECT_NEAR(*truth[0].speed_at(3.0), 34.0, 1e-12);
  EXPECT_NEAR(*truth[0].speed_at(-1.0), 26.0, 1e-12);
  EXPECT_NEAR(*truth[0].range_at(0.25), 95.0, 1e-12);
  EXPECT_EQ(truth[0].range_at(2.5), std::nullopt);
  EXPECT_EQ(truth[1].speed_at(1.0), 15.0);
  EXPECT_EQ(truth[1].speed_at(1.5), std::nullopt);
  EXPECT_TRUE(truth[0].sightings[1].occluded);
  EXPECT_FALSE(truth[0].sightings[1].visible());
}

TEST_F(TruthFolder, RefusesContradictions) {
  EXPECT_THROW(read("car,1,20,0\ncar,1,20,0\n", ""), InputError);
  EXPECT_THROW(read("car,1,-20,0\n", ""), InputError);
  EXPECT_THROW(read("car,1,20,0\n", "0,0,bus,,,,,,,0\n"), InputError);
  EXPECT_THROW(read("car,1,20,0\n", "0,0,car,,,,,,,0\n0,0.1,car,,,,,,,0\n"), InputError);
  EXPECT_THROW(read("car,1,20,0\n", "0,0,car,5,,,,,,0\n"), InputError);
  EXPECT_THROW(read("car,1,20,0\n", "0,0,car,,,,,,,yes\n"), InputError);
}

}  // namespace
}  // namespace vildar
