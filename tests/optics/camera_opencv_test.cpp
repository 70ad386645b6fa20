#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "optics/camera.h"
#include "optics/random_camera.h"

namespace vildar {
namespace {

/// The same projection by OpenCV, with its rotation vector from our matrix.
cv::Point2d opencv_pixel(const CameraSite& site, const Eigen::Matrix3d& camera_from_road,
                         const Eigen::Vector3d& position_m, const Eigen::Vector3d& point_m) {
  cv::Matx33d rotation;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      rotation(row, column) = camera_from_road(row, column);
  cv::Vec3d rotation_vector;
  cv::Rodrigues(rotation, rotation_vector);
  const Eigen::Vector3d shift = -camera_from_road * position_m;
  const cv::Vec3d translation(shift.x(), shift.y(), shift.z());
  const cv::Matx33d lens(site.focal_px[0], 0.0, site.principal_px[0], 0.0, site.focal_px[1],
                         site.principal_px[1], 0.0, 0.0, 1.0);
  const std::vector<cv::Point3d> points{{point_m.x(), point_m.y(), point_m.z()}};
  std::vector<cv::Point2d> pixels;
  const auto& k = site.distortion_coefficients;
  if (site.distortion == DistortionModel::fisheye)
    cv::fisheye::projectPoints(points, pixels, rotation_vector, translation, lens,
                               cv::Vec4d(k[0], k[1], k[2], k[3]));
  else
    cv::projectPoints(points, rotation_vector, translation, lens,
                      cv::Vec<double, 5>(k[0], k[1], k[2], k[3], k[4]), pixels);
  return pixels.at(0);
}

class CameraModel : public ::testing::TestWithParam<DistortionModel> {};

TEST_P(CameraModel, ProjectsAsOpenCvDoes) {
  constexpr double kTolerance_px = 1e-6;  // the rotation goes through a rotation vector and back
  constexpr int kCameras = 100, kPoints = 20;
  Random random(11);
  for (int i = 0; i < kCameras; ++i) {
    const CameraSite site = random_camera(random, GetParam());
    const Camera camera(site);
    for (int j = 0; j < kPoints; ++j) {
      const double depth_m = random.uniform(2.0, 100.0);
      const Eigen::Vector3d point_m =
          camera.position_m() + camera.camera_from_road().transpose() *
                                    Eigen::Vector3d(depth_m * random.uniform(-0.6, 0.6),
                                                    depth_m * random.uniform(-0.4, 0.4), depth_m);
      const auto pixel = camera.project(point_m);
      ASSERT_TRUE(pixel);
      const cv::Point2d truth =
          opencv_pixel(site, camera.camera_from_road(), camera.position_m(), point_m);
      EXPECT_NEAR(pixel->x(), truth.x, kTolerance_px);
      EXPECT_NEAR(pixel->y(), truth.y, kTolerance_px);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Models, CameraModel,
                         ::testing::Values(DistortionModel::none, DistortionModel::brown,
                                           DistortionModel::fisheye));

}  // namespace
}  // namespace vildar
