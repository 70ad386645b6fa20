#include "synth/truth.h"

#include <cmath>
#include <optional>
#include <sstream>

#include <gtest/gtest.h>

#include "optics/camera.h"
#include "scenes.h"
#include "synth/renderer.h"
#include "synth/row_time.h"

#ifdef VILDAR_HAS_CALIB3D
#include <opencv2/calib3d.hpp>
#endif

namespace vildar {
namespace {

TEST(TruthTracks, PixelsBelongToTheRowsOwnTime) {
  Scenario scene = small_scene();
  scene.site.camera->rolling_shutter_s = 0.03;
  scene.vehicles = {car_at(30.0, 25.0)};
  const Camera camera(*scene.site.camera);
  int checked = 0;
  for (const TruthTrackRow& row : truth_tracks(scene)) {
    if (!row.left_px || !row.right_px) continue;
    ++checked;
    // The contract: a lamp at row v of H holds at t_s + ((v + 0.5) / H - 0.5) * rolling_shutter_s.
    for (const bool left : {true, false}) {
      const Eigen::Vector2d pixel_px = left ? *row.left_px : *row.right_px;
      const double time_s = row.time_s + ((pixel_px.y() + 0.5) / 180.0 - 0.5) * 0.03;
      const Eigen::Vector3d lamp_m(30.0 - 25.0 * time_s, -3.0 + (left ? 0.625 : -0.625), 0.65);
      const auto expected_px = camera.project(lamp_m);
      ASSERT_TRUE(expected_px);
      EXPECT_LT((*expected_px - pixel_px).norm(), 1e-6);
    }
    EXPECT_DOUBLE_EQ(row.place_m.x(), 30.0 - 25.0 * row.time_s);
  }
  EXPECT_GT(checked, 5);
}

TEST(TruthTracks, AgreeWithThePictures) {
  Scenario scene = small_scene();
  scene.site.camera->rolling_shutter_s = 0.03;
  scene.vehicles = {car_at(30.0, 25.0)};
  Renderer renderer(scene);
  for (const TruthTrackRow& row : truth_tracks(scene)) {
    if (!row.left_px || !row.right_px) continue;
    const auto lamps = renderer.lamps(row.time_s);
    ASSERT_EQ(lamps.size(), 2u);
    EXPECT_LT((lamps[0].centre_px - *row.left_px).norm(), 1e-9);
    EXPECT_LT((lamps[1].centre_px - *row.right_px).norm(), 1e-9);
  }
}

/// First row of the image, fractions allowed, whose own time finds the point on that very row.
std::optional<double> row_by_bisection(const Camera& camera, const CameraSite& site,
                                       double frame_time_s, const auto& position_m) {
  const auto below = [&](double v_px) -> std::optional<double> {
    const auto pixel = camera.project(position_m(time_of_row_s(site, frame_time_s, v_px)));
    if (!pixel) return std::nullopt;
    return pixel->y() - v_px;
  };
  for (int row = 0; row < site.height_px; ++row) {
    double low_px = row - 0.5, high_px = row + 0.5;
    const auto at_low = below(low_px), at_high = below(high_px);
    if (!at_low || !at_high || (*at_low > 0.0) == (*at_high > 0.0)) continue;
    for (int halving = 0; halving < 50; ++halving) {
      const double middle_px = 0.5 * (low_px + high_px);
      const auto at_middle = below(middle_px);
      if (!at_middle) return std::nullopt;
      ((*at_middle > 0.0) == (*at_low > 0.0) ? low_px : high_px) = middle_px;
    }
    return low_px;
  }
  return std::nullopt;
}

TEST(RowTime, HoldsRightBesideTheCamera) {
  CameraSite site = *small_scene().site.camera;
  site.rolling_shutter_s = 0.03;
  const Camera camera(site);
  int found = 0, passing = 0;
  const auto check = [&](double speed_mps, double beside_m, double below_m, double time_s) {
    const auto position_m = [&](double at_s) {
      return Eigen::Vector3d(speed_mps * at_s, beside_m, camera.position_m().z() - below_m);
    };
    const auto seen = sighting_at_row_time(camera, site, time_s, position_m);
    const auto row_px = row_by_bisection(camera, site, time_s, position_m);
    const auto pixel_px =
        row_px ? camera.project(position_m(time_of_row_s(site, time_s, *row_px))) : std::nullopt;
    const bool inside = pixel_px && inside_image(site, *pixel_px);
    ++(inside ? found : passing);
    EXPECT_EQ(seen && inside_image(site, seen->pixel_px), inside);
    if (!seen) return;
    EXPECT_NEAR(seen->time_s, time_of_row_s(site, time_s, seen->pixel_px.y()), 1e-9);
    if (inside) {
      EXPECT_LT((seen->pixel_px - *pixel_px).norm(), 1e-6);
    }
  };
  for (const double speed_mps : {-30.0, -12.0, 12.0, 30.0})
    for (const double beside_m : {-3.0, -1.5, -0.5, 1.5, 3.0})
      for (const double below_m : {-0.5, 0.0, 0.5, 1.0, 4.3})
        for (double near_m = -1.0; near_m < 5.0; near_m += 0.03)
          check(speed_mps, beside_m, below_m, near_m / speed_mps);
  EXPECT_GT(found, 500);
  EXPECT_GT(passing, 500);
}

#ifdef VILDAR_HAS_CALIB3D
TEST(TruthTracks, ProjectAsOpenCvDoes) {
  Scenario scene = small_scene();
  CameraSite& site = *scene.site.camera;
  site.distortion = DistortionModel::brown;
  site.distortion_coefficients = {-0.1, 0.03, 0.001, -0.002, 0.004};
  site.roll_rad.mean = 0.03;
  scene.vehicles = {car_at(28.0, 20.0)};
  // Rows of the matrix of the contract's worked example are built by hand from the angles.
  const double cy = std::cos(-0.05), sy = std::sin(-0.05), cp = std::cos(-0.12),
               sp = std::sin(-0.12);
  const double cr = std::cos(0.03), sr = std::sin(0.03);
  const Eigen::Vector3d forward(cp * cy, cp * sy, sp), left(-sy, cy, 0.0);
  const Eigen::Vector3d up = forward.cross(left);
  const Eigen::Vector3d right = -(cr * left + sr * up), down = -(cr * up - sr * left);
  cv::Matx33d rotation(right.x(), right.y(), right.z(), down.x(), down.y(), down.z(), forward.x(),
                       forward.y(), forward.z());
  cv::Mat rotation_vector;
  cv::Rodrigues(rotation, rotation_vector);
  const cv::Vec3d translation = -(rotation * cv::Vec3d(0.0, 0.0, 5.0));
  const cv::Matx33d intrinsics(300.0, 0.0, 159.5, 0.0, 300.0, 89.5, 0.0, 0.0, 1.0);
  int checked = 0;
  for (const TruthTrackRow& row : truth_tracks(scene)) {
    if (!row.left_px || !row.right_px) continue;
    ++checked;
    const double x_m = 28.0 - 20.0 * row.time_s;
    std::vector<cv::Point2d> pixels;
    cv::projectPoints(std::vector<cv::Point3d>{{x_m, -2.375, 0.65}, {x_m, -3.625, 0.65}},
                      rotation_vector, translation, intrinsics,
                      std::vector<double>{-0.1, 0.03, 0.001, -0.002, 0.004}, pixels);
    EXPECT_NEAR(pixels[0].x, row.left_px->x(), 1e-6);
    EXPECT_NEAR(pixels[0].y, row.left_px->y(), 1e-6);
    EXPECT_NEAR(pixels[1].x, row.right_px->x(), 1e-6);
    EXPECT_NEAR(pixels[1].y, row.right_px->y(), 1e-6);
  }
  EXPECT_GT(checked, 5);
}
#endif

TEST(TruthTracks, SayWhenAnotherBodyHidesTheVehicle) {
  Scenario scene = small_scene();
  VehicleScene lorry = car_at(20.0, 0.0);
  lorry.kind = VehicleKind::lorry;
  lorry.id = "lorry";
  scene.vehicles = {car_at(36.0, 0.0), lorry, car_at(19.0, 0.0)};
  scene.vehicles[2].id = "hidden at no time";
  const auto rows = truth_tracks(scene);
  // A vehicle that is never seen has no row.
  for (const TruthTrackRow& row : rows) EXPECT_NE(row.vehicle, 0u);
  // Seen first, then overtaken by the shadow: rows stay, with pixels, and say so.
  scene.vehicles[0].along_at_zero_m = 140.0;
  scene.vehicles[0].lateral_offset_m = -10.0;
  scene.vehicles[0].speed_mps = 100.0;
  int hidden = 0, seen = 0;
  for (const TruthTrackRow& row : truth_tracks(scene)) {
    if (row.vehicle != 0) continue;
    hidden += row.occluded;
    seen += row.seen;
    EXPECT_FALSE(row.occluded && row.seen);
    if (row.occluded) {
      EXPECT_TRUE(row.left_px || row.right_px);
    }
  }
  EXPECT_GT(hidden, 0);
  EXPECT_GT(seen, 0);
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(TruthCsv, HoldsToTheContract) {
  Scenario scene = small_scene();
  scene.vehicles = {car_at(40.0, 20.0)};
  scene.vehicles[0].acceleration_mps2 = -1.0;
  const auto rows = truth_tracks(scene);
  ASSERT_EQ(rows.size(), 10u);
  const auto tracks = lines_of(truth_tracks_csv(scene, rows));
  EXPECT_EQ(tracks[0],
            "frame,t_s,vehicle_id,u_left_px,v_left_px,u_right_px,v_right_px,x_m,y_m,range_m,"
            "speed_mps,occluded");
  EXPECT_EQ(tracks.size(), 11u);
  const auto vehicles = lines_of(truth_vehicles_csv(scene, rows));
  ASSERT_EQ(vehicles.size(), 2u);
  EXPECT_EQ(vehicles[0],
            "vehicle_id,direction,lane,t_ref_s,speed_mps,range_ref_m,lateral_m,acceleration_mps2");
  // Seen from 0 to 0.36 s, so at 0.18 s: v = 20 - 0.18, x = 40 - 20 * 0.18 + 0.18^2 / 2.
  EXPECT_EQ(vehicles[1], "car,oncoming,near,0.180000,19.820000,36.4162,-3.0000,-1.0000");
}

TEST(TruthCsv, WithoutACameraAtAHundredHertzAndWithoutPixels) {
  Scenario scene = small_scene();
  scene.site.camera.reset();
  scene.vehicles = {car_at(40.0, 20.0)};
  const auto lines = lines_of(truth_tracks_csv(scene, truth_tracks(scene)));
  ASSERT_EQ(lines.size(), 41u);
  EXPECT_EQ(lines[2], "1,0.010000,car,,,,,39.8000,-3.0000,39.8000,20.0000,0");
}

}  // namespace
}  // namespace vildar
