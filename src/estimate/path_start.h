#pragma once

#include <optional>
#include <vector>

#include "estimate/camera_view.h"
#include "estimate/geometry_fit.h"
#include "estimate/path_model.h"

namespace vildar {

/// Nominal metric sizes to start from; only start values, never evidence.
struct NominalSizes {
  double drop_m = 0.0;  ///< camera height less lamp height
  double separation_m = 1.25;
  std::optional<double> lateral_m;  ///< from the camera, of the lane that is meant
  double radius_m = 0.0;            ///< of a curved road's line y = 0
};

/// Ground points of a vehicle, relative to the camera's foot, by one way of reading the bearings.
struct RoughPoint {
  double time_s = 0.0;
  Eigen::Vector2d place_m = Eigen::Vector2d::Zero();
  double drop_m = 0.0;
  double separation_m = 0.0;
};
using RoughPath = std::vector<RoughPoint>;

/// By the lamps' elevation, by the pair's width, by the lane's lateral offset: those that apply.
std::vector<RoughPath> rough_paths(const CameraView& view, const PathSetting& setting,
                                   const NominalSizes& sizes);

/// Mean time, near points counting more.
double reference_time_s(const RoughPath& path);

/// Where the camera looks: as the site file says, or so that the path is level and straight.
enum class Look { as_told, by_path };

/// Straight-line motion along the road through a rough path, with the setting, reference time and
/// own heading of `problem`; nothing where it does not lie ahead.
std::optional<PathVector> start_of(const RoughPath& path, const GeometryProblem& problem,
                                   const RoadSite& road, const EgoMotion& ego,
                                   const NominalSizes& sizes, Look look = Look::as_told);

}  // namespace vildar
