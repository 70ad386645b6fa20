#pragma once

#include <vector>

#include "optics/camera.h"
#include "synth/scenario.h"

namespace vildar {

/// What the camera sees without any lamp: sky, verge, asphalt with painted edge lines. cd/m^2 per
/// pixel, row by row.
std::vector<float> background_cd_per_m2(const Camera& camera, const CameraSite& site,
                                        const RoadSite& road, const ImageScene& image);

}  // namespace vildar
