#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include "types/frame.h"

namespace vildar {

struct RimCircle {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  double radius_px = 0.0;
  double centre_sigma_px = 0.0;  ///< per axis
};

/// The circle of a clipped disc that runs into others, from the rim it shows on its free sides.
/// `start_px` lies inside the disc on a clipped pixel; `hidden` are the unit directions, seen from
/// there, of what it runs into. Nothing where too little rim is free or no circle fits it.
std::optional<RimCircle> fit_rim(const LumaView& luma, int clip_code,
                                 const Eigen::Vector2d& start_px,
                                 std::span<const Eigen::Vector2d> hidden);

}  // namespace vildar
