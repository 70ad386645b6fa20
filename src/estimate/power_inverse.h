#pragma once

#include <span>
#include <vector>

#include "estimate/power_model.h"

namespace vildar {

/// Path length to the sensor's cross-line that each power implies.
struct ImpliedPath {
  std::vector<double> along_m;
  std::vector<double> steepness;  ///< |dP/d along| there, the weight of the transform
  std::vector<char> inside;  ///< 0: no such place (not positive, or brighter or darker than any)
};

/// Exact inverse of the law on its outer branch: from far away up to the place of greatest power
/// (a cosine makes the power fall again nearer than that). Speed, range and acceleration of
/// `parameters` are not used. Curved roads: up to beta = pi.
ImpliedPath implied_path(std::span<const double> power_w, const PowerVector& parameters,
                         const PowerSetting& setting);

}  // namespace vildar
