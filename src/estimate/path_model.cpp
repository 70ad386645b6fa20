#include "estimate/path_model.h"

namespace vildar {

PathSetting path_setting(const CameraSite& camera, const RoadSite& road) {
  PathSetting setting;
  for (int axis = 0; axis < 3; ++axis)
    setting.camera_m[axis] = camera.position_m[static_cast<std::size_t>(axis)].mean;
  setting.camera_from_road =
      camera_from_road_rotation(camera.yaw_rad.mean, camera.pitch_rad.mean, camera.roll_rad.mean);
  setting.yaw_rad = camera.yaw_rad.mean;
  setting.pitch_rad = camera.pitch_rad.mean;
  setting.roll_rad = camera.roll_rad.mean;
  setting.turns =
      camera.yaw_rad.std > 0.0 || camera.pitch_rad.std > 0.0 || camera.roll_rad.std > 0.0;
  setting.focal_unsure = camera.focal_std_px > 0.0;
  setting.bend = road.radius_m ? bend_of(road) : 0.0;
  const Uncertain straight_m = bend_begins_m(road);
  setting.straight_m = straight_m.mean;
  setting.straight_unsure = setting.bend != 0.0 && straight_m.std > 0.0;
  return setting;
}

}  // namespace vildar
