#pragma once

#include <array>
#include <string_view>

#include <Eigen/Core>

namespace vildar {

/// How the slopes of the mirroring facets of a surface are spread.
enum class FacetLaw { ggx, beckmann };

/// Facets that mirror by Fresnel, with height-correlated Smith masking.
struct FacetLobe {
  double share = 0.0;      ///< of the surface, 0 to 1
  double roughness = 0.5;  ///< slope scale of the facets, > 0
};

/// Reciprocal reflection of a road: a diffuse part and two lobes of facets. Sends out no more light
/// than comes in where the albedo and the two shares together are at most 1.
struct RoadSurface {
  double diffuse_albedo = 0.1;
  double refractive_index = 1.5;
  FacetLaw law = FacetLaw::ggx;
  std::array<FacetLobe, 2> lobes{};

  /// Luminance per illuminance (the luminance coefficient q of road lighting), in 1/sr. Unit
  /// vectors away from the surface, z along its normal; 0 where either lies below the surface.
  double brdf_per_sr(const Eigen::Vector3d& to_light, const Eigen::Vector3d& to_viewer) const;
};

/// Surfaces fitted to the road reflection tables of the CIE: dry R1 (light, diffuse) to R4 (dark,
/// glossy), and C2 wet in two degrees. The tables were measured at 1 degree of observation and up
/// to tan(gamma) = 12; elsewhere these are extrapolations by physics, not measurements.
enum class RoadTable { r1, r2, r3, r4, c2w3, c2w4 };
const RoadSurface& road_surface(RoadTable table);

/// "R1" to "C2W4".
std::string_view name_of(RoadTable table);

}  // namespace vildar
