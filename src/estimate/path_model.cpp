#include "estimate/path_model.h"

namespace vildar {

PathSetting path_setting(const CameraSite& camera, const RoadSite& road) {
  PathSetting setting;
  for (int axis = 0; axis < 3; ++axis)
    setting.camera_m[axis] = camera.position_m[static_cast<std::size_t>(axis)].mean;
  setting.camera_from_road =
      camera_from_road_rotation(camera.yaw_rad.mean, camera.pitch_rad.mean, camera.roll_rad.mean);
  // Yaw turns about the vertical, pitch lifts about the yawed right-hand axis, roll turns about the
  // viewing axis.
  const double yaw_rad = camera.yaw_rad.mean;
  setting.turn_axes.col(0) = Eigen::Vector3d::UnitZ();
  setting.turn_axes.col(1) = Eigen::Vector3d(std::sin(yaw_rad), -std::cos(yaw_rad), 0.0);
  setting.turn_axes.col(2) = setting.camera_from_road.row(2).transpose();
  setting.bend = road.radius_m ? bend_of(road) : 0.0;
  setting.straight_m = road.straight_m;
  return setting;
}

}  // namespace vildar
