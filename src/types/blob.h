#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/clock.h"

namespace vildar {

/// `bad_fit`: not the picture of a lamp behind the calibrated point-spread function.
enum class Defect : std::uint8_t {
  none = 0,
  saturated = 1,
  cut_by_edge = 2,
  merged = 4,
  bad_fit = 8
};
constexpr Defect operator|(Defect a, Defect b) {
  return static_cast<Defect>(static_cast<int>(a) | static_cast<int>(b));
}
constexpr bool has(Defect set, Defect one) {
  return (static_cast<int>(set) & static_cast<int>(one)) != 0;
}

/// What a light is. `other` where it cannot be told.
enum class LampKind : std::uint8_t { headlamp, taillamp, reflection, street, other };
/// One a headlamp, the other a tail lamp.
constexpr bool opposed(LampKind a, LampKind b) {
  return (a == LampKind::headlamp && b == LampKind::taillamp) ||
         (a == LampKind::taillamp && b == LampKind::headlamp);
}

/// Pixel box, both ends included.
struct PixelBox {
  int u_min = 0, v_min = 0, u_max = 0, v_max = 0;
};

/// All the light of a lamp, also what falls on pixels that clip, in the units of Blob::flux, and
/// the disc that it is seen as: from a fit of the calibrated point-spread function.
struct LampLight {
  double flux = 0.0;
  double flux_sigma = 0.0;
  double radius_px = 0.0;
  double radius_sigma_px = 0.0;
  /// At a given rim a smaller lamp is a brighter one. Were the radius known, d px above this one,
  /// ln flux would be `log_flux_per_radius` d more, with a sigma of `log_flux_sigma_at_radius`.
  double log_flux_per_radius = 0.0;
  double log_flux_sigma_at_radius = 0.0;
  /// From a picture coded with loss: errs alike in many pictures and otherwise as the lamp grows,
  /// so that its change over time is not known as well as the flux.
  bool coded = false;

  /// Whether the flux is known to better than 30 %.
  bool told() const {
    constexpr double kMostSigma = 0.3;  // of the flux
    return flux_sigma < kMostSigma * flux;
  }
};

/// The lamp's light where a fit tells it, else what is seen of it; of a Blob or a LampSighting.
template <class Seen>
LampLight light_of(const Seen& seen) {
  return seen.lamp && seen.lamp->told() ? *seen.lamp : LampLight{seen.flux, seen.flux_sigma};
}

/// Whether light_of() is a lower bound: of a lamp that clips and no fit tells, or that the picture
/// cuts.
template <class Seen>
bool is_bound(const Seen& seen) {
  return has(seen.defects, Defect::cut_by_edge) ||
         (has(seen.defects, Defect::saturated) && !(seen.lamp && seen.lamp->told()));
}

/// One bright spot of one frame. Positions are in the upright image (after the clip's rotation),
/// pixel (0, 0) being the centre of the top-left pixel.
struct Blob {
  int id = 0;  ///< unique within the frame, from 0
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d centre_sigma_px = Eigen::Vector2d::Constant(1.0);
  /// Linear light above the local background, in units of one pixel at nominal white, divided by
  /// the exposure (when the site gives it). A lower bound where `saturated`, with a sigma as wide.
  double flux = 0.0;
  double flux_sigma = 0.0;
  /// Absent without a calibrated point-spread function, with Defect::bad_fit, and where the fit
  /// does not tell the flux; in pictures coded with loss, where it would not at a known radius
  /// either.
  std::optional<LampLight> lamp;
  int area_px = 0;       ///< pixels above the blob's threshold
  int saturated_px = 0;  ///< pixels at or above the clipping code
  PixelBox box;
  /// Standard deviation of the light about the centre along the image axes, px.
  Eigen::Vector2d spread_px = Eigen::Vector2d::Zero();
  /// Mean Cr and Cb of the blob's rim (where luma does not clip), fractions in [-0.5, 0.5], of a
  /// dim light as were it bright (own_colour()); 0 for grey clips.
  double cr = 0.0;
  double cb = 0.0;
  /// Standard deviation by which coding leaves a dim light's colour to chance, beyond a bright
  /// one's.
  double colour_chance = 0.0;
  /// (row + 0.5) / rows - 0.5 in readout order, for the rolling shutter.
  double row_fraction = 0.0;
  Defect defects = Defect::none;
  LampKind kind =
      LampKind::other;  ///< first from this frame alone; the tracker may know better later
};

/// All blobs of one frame.
struct BlobFrame {
  std::int64_t frame = 0;
  CameraTime time;
  std::vector<Blob> blobs;
};

}  // namespace vildar
