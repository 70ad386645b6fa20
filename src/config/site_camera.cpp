#include "config/site_camera.h"

#include <algorithm>
#include <cmath>

#include "config/site_words.h"
#include "core/quantity.h"
#include "core/text.h"
#include "optics/road.h"

namespace vildar {
namespace {

constexpr NumberRule kPixels{1.0, 32'768.0, false, false};
constexpr NumberRule kFocal_px{1.0, 1e6, false, false};
constexpr NumberRule kFocalStd_px{0.0, 1e5, false, false};
constexpr double kMostFocalStd = 0.2;  // of the focal length
constexpr NumberRule kExposure_s{0.0, 10.0, true, false};
constexpr NumberRule kRollingShutter_s{0.0, 1.0, false, false};
constexpr NumberRule kCoreSigma_px{0.5, 20.0, false, false};
constexpr NumberRule kWingShare{0.0, 0.9, false, false};
constexpr NumberRule kWingScale_px{0.5, 100.0, false, false};
constexpr NumberRule kWingExponent{2.0, 10.0, true, false};
constexpr NumberRule kFromMast_m{-1000.0, 1000.0, false, false, "metres"};
constexpr double kHighest_m = 100.0;  // over the road, or below it

void read_distortion(const YamlMap& map, CameraSite& camera) {
  const auto item = map.find("distortion");
  if (!item) return;
  if (item->is_scalar()) {  // `distortion: none`
    if (item->get(camera.distortion, kDistortionWords) &&
        camera.distortion != DistortionModel::none)
      item->problem("has no coefficients", "write {model: ..., coefficients: [...]}");
    return;
  }
  const auto distortion = item->map();
  if (!distortion) return;
  if (!distortion->require("model", camera.distortion, kDistortionWords)) {
    distortion->find("coefficients");  // nothing can be said of them
    return;
  }
  std::vector<double> coefficients;
  const std::size_t wanted = coefficient_count(camera.distortion);
  if (wanted == 0) {
    distortion->refuse("coefficients", "the model none takes no coefficients",
                       "remove them, or name the model brown or fisheye");
    return;
  }
  if (!distortion->require("coefficients", coefficients)) return;
  if (coefficients.size() != wanted) {
    distortion->problem(
        "coefficients",
        "has " + std::to_string(coefficients.size()) + " values, the model takes " +
            std::to_string(wanted),
        wanted == 5 ? "give k1, k2, p1, p2, k3 (0 where not fitted)" : "give k1, k2, k3, k4");
    return;
  }
  std::copy(coefficients.begin(), coefficients.end(), camera.distortion_coefficients.begin());
}

// A lens may look off its sensor's middle, also far for a cropped picture, but not by pictures.
void read_principal(const YamlMap& map, CameraSite& camera) {
  if (!map.require("principal_px", camera.principal_px)) return;
  const std::array<int, 2> size_px{camera.width_px, camera.height_px};
  for (std::size_t i = 0; i < 2; ++i) {
    if (size_px[i] <= 0) continue;
    const double low = -1.0 * size_px[i], high = 2.0 * size_px[i];
    if (camera.principal_px[i] < low || camera.principal_px[i] > high)
      map.problem("principal_px",
                  number_text(camera.principal_px[i]) + " is far outside the picture",
                  "must be from " + number_text(low) + " to " + number_text(high));
  }
}

void read_response(const YamlMap& map, CameraSite& camera) {
  const auto response = map.map("response");
  if (!response) return;
  if (!response->require("kind", camera.response, kResponseWords)) {
    response->find("exponent");  // nothing can be said of these
    response->find("values");
    return;
  }
  if (camera.response == ResponseKind::gamma)
    response->require("exponent", camera.response_exponent, kPositive);
  else
    response->refuse("exponent", "belongs to kind gamma alone", "remove it");
  if (camera.response != ResponseKind::table) {
    response->refuse("values", "belong to kind table alone", "remove them");
    return;
  }
  const auto values = response->find_required("values");
  if (!values || !values->get(camera.response_table, kNotNegative)) return;
  const std::vector<double>& table = camera.response_table;
  if (table.size() != kResponseTableSize) {
    values->problem("has " + std::to_string(table.size()) + " values",
                    "give 256, the linear light of each code from 0 to 255");
    return;
  }
  const auto fall = std::adjacent_find(table.begin(), table.end(),
                                       [](double low, double high) { return !(high > low); });
  if (fall != table.end())
    values->problem("value " + std::to_string(fall - table.begin() + 1) + " (" +
                        number_text(*(fall + 1)) + ") is not above the one before it (" +
                        number_text(*fall) + ")",
                    "must increase from code to code");
}

void read_psf(const YamlMap& map, CameraSite& camera) {
  const auto item = map.map("psf");
  if (!item) return;
  PsfShape shape;
  Uncertain wing_share;
  bool whole = item->require("core_sigma_px", shape.core_sigma_px, kCoreSigma_px);
  whole &= item->require("wing_share", wing_share, kWingShare);
  whole &= item->require("wing_scale_px", shape.wing_scale_px, kWingScale_px);
  whole &= item->require("wing_exponent", shape.wing_exponent, kWingExponent);
  shape.wing_share = wing_share.mean;
  if (whole) camera.psf = PsfSite{shape, wing_share.std};
}

}  // namespace

bool require_position(const YamlMap& map, std::array<Uncertain, 3>& position_m) {
  if (!map.require("position_m", position_m, kFromMast_m)) return false;
  if (std::abs(position_m[2].mean) <= kHighest_m) return true;
  map.problem("position_m", "z is " + number_text(position_m[2].mean),
              "must be <= " + number_text(kHighest_m) +
                  ", in metres: z is the height above the road surface");
  return false;
}

CameraSite read_camera(const YamlMap& map) {
  CameraSite camera;
  std::array<int, 2> size_px{};
  map.require("image_size_px", size_px, kPixels);
  camera.width_px = size_px[0];
  camera.height_px = size_px[1];
  map.require("focal_px", camera.focal_px, kFocal_px);
  if (map.read("focal_std_px", camera.focal_std_px, kFocalStd_px) && camera.focal_px[0] > 0.0 &&
      camera.focal_std_px > kMostFocalStd * camera.focal_px[0])
    map.problem("focal_std_px", number_text(camera.focal_std_px) + " is over a fifth of focal_px",
                "give its standard deviation in pixels; calibrate the camera");
  read_principal(map, camera);
  read_distortion(map, camera);
  if (require_position(map, camera.position_m) && !(camera.position_m[2].mean > 0.0))
    map.problem("position_m", "z is " + number_text(camera.position_m[2].mean),
                "must be > 0: z is the height above the road surface");
  // An angle left out is unknown, not zero: a level camera looking up-road, give or take this much.
  camera.yaw_rad = camera.pitch_rad = {0.0, radians_from_degrees(5.0)};
  camera.roll_rad = {0.0, radians_from_degrees(2.0)};
  map.read_degrees("yaw_deg", camera.yaw_rad);
  map.read_degrees("pitch_deg", camera.pitch_rad, kPitch_deg);
  map.read_degrees("roll_deg", camera.roll_rad);
  map.read("exposure_s", camera.exposure_s, kExposure_s);
  map.read("rolling_shutter_s", camera.rolling_shutter_s, kRollingShutter_s);
  read_response(map, camera);
  read_psf(map, camera);
  map.read("gain_db", camera.gain_db);
  map.read("path_loss_exponent", camera.path_loss_exponent, kPositive);
  return camera;
}

void suppose_aim(const YamlMap& map, const RoadSite& road, CameraSite& camera) {
  constexpr double kLooksAt_m = 40.0, kNearest_m = 20.0, kFarthest_m = 100.0;
  constexpr double kOfRange = 0.25;  // two sigmas either way
  const auto& [x_m, y_m, z_m] = camera.position_m;
  const auto spread_rad = [&](double aside_m) {
    return kOfRange * std::abs(std::atan2(aside_m, kNearest_m) - std::atan2(aside_m, kFarthest_m));
  };
  if (!map.has("pitch_deg"))
    camera.pitch_rad = {-std::atan2(z_m.mean, kLooksAt_m),
                        std::max(radians_from_degrees(4.0), spread_rad(z_m.mean))};
  if (map.has("yaw_deg") || road.lanes.empty()) return;
  double lateral_m = 0.0;
  for (const LaneSite& lane : road.lanes)
    lateral_m += lane.lateral_m.mean / static_cast<double>(road.lanes.size());
  const double radius_m = road.radius_m ? road.radius_m->mean : 0.0;
  const PathPoint<double> there =
      path_point(x_m.mean + kLooksAt_m, lateral_m, road.radius_m ? bend_of(road) : 0.0,
                 road.straight_m.mean, radius_m);
  camera.yaw_rad = {std::atan2(there.y_m - y_m.mean, there.x_m - x_m.mean),
                    std::max(radians_from_degrees(5.0), spread_rad(there.y_m - y_m.mean))};
}

}  // namespace vildar
