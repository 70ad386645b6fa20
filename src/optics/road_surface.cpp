#include "optics/road_surface.h"

#include <algorithm>
#include <cmath>

#include "core/quantity.h"
#include "optics/fresnel.h"

namespace vildar {
namespace {

/// Made by tools/fit_road_surface.py from the CIE's road reflection tables (publications 66
/// and 144), in the order of RoadTable. Fit errors stand in docs/light.md and are held by the
/// tests.
constexpr std::array<RoadSurface, 6> kFitted{{
    {0.21774, 1.5, FacetLaw::ggx, {{{0.03337, 0.27582}, {0.72903, 0.94617}}}},
    {0.11999, 1.5, FacetLaw::ggx, {{{0.00099, 0.04939}, {0.46942, 0.52695}}}},
    {0.07393, 1.5, FacetLaw::ggx, {{{0.00076, 0.03715}, {0.69168, 0.52665}}}},
    {0.06454, 1.5, FacetLaw::ggx, {{{0.75072, 0.49419}, {0.00983, 0.07643}}}},
    {0.08496, kWaterIndex, FacetLaw::beckmann, {{{0.43864, 0.25855}, {0.42014, 0.36952}}}},
    {0.08443, kWaterIndex, FacetLaw::beckmann, {{{0.50910, 0.20710}, {0.38650, 0.37495}}}},
}};

/// Smith's masking integral of one direction.
double masking(FacetLaw law, double cosine, double roughness) {
  const double spread = roughness * std::sqrt(std::max(0.0, 1.0 - cosine * cosine)) / cosine;
  if (law == FacetLaw::ggx) return 0.5 * (std::sqrt(1.0 + spread * spread) - 1.0);
  // Facets this steep against the ray are rarer than rounding.
  if (spread < 0.05) return 0.0;
  const double a = 1.0 / spread;
  return 0.5 * (std::erf(a) - 1.0) + std::exp(-a * a) / (2.0 * a * std::sqrt(kPi));
}

/// Facets per solid angle of their normals, projected: its integral times the cosine is 1.
double facet_density(FacetLaw law, double cosine, double roughness) {
  const double squared = cosine * cosine;
  const double slope_squared = (1.0 - squared) / squared / (roughness * roughness);
  const double fall = law == FacetLaw::ggx ? 1.0 / ((1.0 + slope_squared) * (1.0 + slope_squared))
                                           : std::exp(-slope_squared);
  return fall / (kPi * roughness * roughness * squared * squared);
}

}  // namespace

double RoadSurface::brdf_per_sr(const Eigen::Vector3d& to_light,
                                const Eigen::Vector3d& to_viewer) const {
  const double cos_in = to_light.z(), cos_out = to_viewer.z();
  if (!(cos_in > 0.0) || !(cos_out > 0.0)) return 0.0;
  const Eigen::Vector3d half = (to_light + to_viewer).normalized();
  const double reflectance =
      fresnel_reflectance(std::clamp(half.dot(to_viewer), 0.0, 1.0), refractive_index);
  const double cos_tilt = std::min(half.z(), 1.0);
  double brdf = diffuse_albedo / kPi;
  for (const FacetLobe& lobe : lobes) {
    if (!(lobe.share > 0.0)) continue;
    const double seen =
        1.0 / (1.0 + masking(law, cos_in, lobe.roughness) + masking(law, cos_out, lobe.roughness));
    brdf += lobe.share * reflectance * facet_density(law, cos_tilt, lobe.roughness) * seen /
            (4.0 * cos_in * cos_out);
  }
  return brdf;
}

const RoadSurface& road_surface(RoadTable table) {
  return kFitted[static_cast<std::size_t>(table)];
}

std::string_view name_of(RoadTable table) {
  constexpr std::array<std::string_view, 6> kNames{"R1", "R2", "R3", "R4", "C2W3", "C2W4"};
  return kNames[static_cast<std::size_t>(table)];
}

}  // namespace vildar
