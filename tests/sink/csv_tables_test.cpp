#include "sink/csv_tables.h"

#include <fstream>
#include <sstream>

#include "sink/support.h"

namespace vildar {
namespace {

using test::Folder;
using test::lines_of;

constexpr std::string_view kSpeedsHeader =
    "track_id,direction,lane,status,t_first_s,t_last_s,t_ref_s,speed_mps,speed_std_mps,speed_lo95_"
    "mps,speed_hi95_mps,"
    "speed_kmh,range_ref_m,lateral_m,acceleration_mps2,sensors,method,n_frames,n_pd_samples,"
    "closing_speed_mps";
constexpr std::string_view kTracksHeader =
    "frame,t_s,track_id,u_left_px,v_left_px,u_right_px,v_right_px,intensity,intensity_std,"
    "saturated,azimuth_rad,"
    "elevation_rad,range_m,range_std_m,speed_mps,speed_std_mps,intensity_left,intensity_right,"
    "azimuth_left_rad,"
    "elevation_left_rad,azimuth_right_rad,elevation_right_rad,u_left_std_px,v_left_std_px,"
    "u_right_std_px,v_right_std_px";

TEST(CsvRow, QuotesWhatWouldBreakTheTableAndNothingElse) {
  CsvRow row;
  row.text("near lane").text("a,b").text("say \"hi\"").text("two\nlines").integer(-3).empty();
  EXPECT_EQ(row.line(), "near lane,\"a,b\",\"say \"\"hi\"\"\",\"two\nlines\",-3,\n");
}

TEST(CsvRow, NumbersThatAreNotFiniteAreEmptyCells) {
  CsvRow row;
  row.fixed(std::nan(""), 3)
      .fixed(std::nullopt, 3)
      .significant(INFINITY, 5)
      .fixed(-0.25, 3)
      .significant(1.5e-9, 7);
  EXPECT_EQ(row.line(), ",,,-0.250,1.5e-09\n");
}

TEST(Speeds, WithoutVehiclesThereIsTheHeaderAlone) {
  const Folder folder;
  write_speeds(folder / "speeds.csv", {}).commit();
  EXPECT_EQ(lines_of(folder / "speeds.csv"), std::vector<std::string>{std::string(kSpeedsHeader)});
}

TEST(Speeds, MeasuredRowCarriesEveryColumn) {
  const Folder folder;
  const std::vector<VehicleResult> vehicles{test::measured_vehicle()};
  write_speeds(folder / "speeds.csv", vehicles).commit();
  const auto lines = lines_of(folder / "speeds.csv");
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[1],
            "3,oncoming,\"near, "
            "left\",measured,1.250000,4.500000,2.125000,14.500000,0.200000,14.108000,14.892000,"
            "52.200000,31.5000,-4.0000,,camera+photodiode,fused,98,3250,14.500000");
}

TEST(Speeds, WithheldRowNamesTheReasonAndGivesNoSpeed) {
  const Folder folder;
  const std::vector<VehicleResult> vehicles{test::withheld_vehicle()};
  write_speeds(folder / "speeds.csv", vehicles).commit();
  EXPECT_EQ(lines_of(folder / "speeds.csv").at(1),
            "4,receding,,withheld:too_short,5.000000,5.200000,,,,,,,,,,camera,,6,0,");
}

TEST(Methods, OneRowPerMethodWithItsStatus) {
  const Folder folder;
  const std::vector<VehicleResult> vehicles{test::measured_vehicle(), test::withheld_vehicle()};
  write_methods(folder / "methods.csv", vehicles).commit();
  const auto lines = lines_of(folder / "methods.csv");
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(lines[0],
            "track_id,method,status,t_ref_s,speed_mps,speed_std_mps,speed_lo95_mps,speed_hi95_mps,"
            "n_samples,k_source");
  EXPECT_EQ(lines[1],
            "3,power_slope_photodiode,measured,2.125000,14.500000,0.200000,14.108000,14.892000,"
            "3250,bearings");
  EXPECT_EQ(lines[2], "3,curved_angle_camera,withheld:outside_model,,,,,,98,");
}

TrackRow track_row() {
  TrackRow row;
  row.track_id = 3;
  row.sighting.frame = 41;
  row.time_s = 1.3666667;
  row.intensity = 1234.5678912;
  row.intensity_std = 2.5e-3;
  LampSighting left;
  left.centre_px = {100.25, 50.5};
  left.centre_sigma_px = {0.05, 0.0625};
  left.flux = 617.0;
  left.saturated_px = 3;
  row.sighting.left = left;
  row.bearing_rad = Eigen::Vector2d(-0.125, -0.0625);
  row.range_m = 40.0;
  return row;
}

TEST(Tracks, LampNotSeenIsEmpty) {
  const Folder folder;
  TracksWriter writer(folder / "tracks.csv");
  writer.add(std::vector<TrackRow>{track_row()});
  std::move(writer).finish().commit();
  const auto lines = lines_of(folder / "tracks.csv");
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0], kTracksHeader);
  EXPECT_EQ(lines[1],
            "41,1.366667,3,100.2500,50.5000,,,1234.568,0.0025,3,-0.12500000,-0.06250000,40.0000,,,,"
            "617,,,,,,0.0500,0.0625,,");
}

TEST(Tracks, ALampCutByTheEdgeHasNoSigma) {
  const Folder folder;
  TrackRow row = track_row();
  row.sighting.left->defects = Defect::cut_by_edge;
  TracksWriter writer(folder / "tracks.csv");
  writer.add(std::vector<TrackRow>{row});
  std::move(writer).finish().commit();
  EXPECT_TRUE(lines_of(folder / "tracks.csv").at(1).ends_with(",617,,,,,,,,,"));
}

TEST(Tracks, NothingStandsUnderTheNameBeforeCommit) {
  const Folder folder;
  {
    TracksWriter writer(folder / "tracks.csv");
    for (int i = 0; i < 1000; ++i) writer.add(std::vector<TrackRow>{track_row()});
    EXPECT_FALSE(std::filesystem::exists(folder / "tracks.csv"));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Blobs, OneRowPerBlob) {
  const Folder folder;
  BlobsWriter writer(folder / "blobs.csv");
  BlobFrame frame;
  frame.frame = 7;
  frame.time = time_from_seconds<CameraTime>(0.28);
  Blob blob;
  blob.id = 1;
  blob.centre_px = {10.5, 20.25};
  blob.centre_sigma_px = {0.05, 0.0625};
  blob.flux = 12.5;
  blob.flux_sigma = 0.125;
  blob.area_px = 30;
  blob.saturated_px = 4;
  blob.kind = LampKind::taillamp;
  frame.blobs = {blob};
  writer.add(frame);
  frame.blobs.clear();
  writer.add(frame);
  std::move(writer).finish().commit();
  EXPECT_EQ(
      lines_of(folder / "blobs.csv"),
      (std::vector<std::string>{
          "frame,t_s,blob_id,u_px,v_px,u_std_px,v_std_px,flux,flux_std,area_px,saturated_px,kind",
          "7,0.280000,1,10.5000,20.2500,0.0500,0.0625,12.5,0.125,30,4,taillamp"}));
}

TEST(Tables, AFolderThatCannotBeMadeIsAnOutputError) {
  const Folder folder;
  std::ofstream(folder / "file") << "x";
  EXPECT_THROW((void)write_speeds(folder / "file" / "speeds.csv", {}), OutputError);
}

}  // namespace
}  // namespace vildar
