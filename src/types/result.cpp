#include "types/result.h"

namespace vildar {

std::string_view name_of(Method method) {
  switch (method) {
    case Method::power_slope_camera: return "power_slope_camera";
    case Method::power_slope_photodiode: return "power_slope_photodiode";
    case Method::curved_angle_camera: return "curved_angle_camera";
    case Method::curved_angle_photodiode: return "curved_angle_photodiode";
    case Method::ml_photodiode: return "ml_photodiode";
    case Method::delay_photodiodes: return "delay_photodiodes";
    case Method::geometry_camera: return "geometry_camera";
    case Method::fused: return "fused";
  }
  return "unknown";
}

std::string_view name_of(Direction direction) {
  return direction == Direction::oncoming ? "oncoming" : "receding";
}

std::string_view name_of(LampKind kind) {
  switch (kind) {
    case LampKind::headlamp: return "headlamp";
    case LampKind::taillamp: return "taillamp";
    case LampKind::reflection: return "reflection";
    case LampKind::street: return "street";
    case LampKind::other: return "other";
  }
  return "unknown";
}

}  // namespace vildar
