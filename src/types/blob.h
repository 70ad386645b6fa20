#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/clock.h"

namespace vildar {

enum class Defect : std::uint8_t { none = 0, saturated = 1, cut_by_edge = 2, merged = 4 };
constexpr Defect operator|(Defect a, Defect b) {
  return static_cast<Defect>(static_cast<int>(a) | static_cast<int>(b));
}
constexpr bool has(Defect set, Defect one) {
  return (static_cast<int>(set) & static_cast<int>(one)) != 0;
}

/// What a light is. `other` where it cannot be told.
enum class LampKind : std::uint8_t { headlamp, taillamp, reflection, street, other };

/// Pixel box, both ends included.
struct PixelBox {
  int u_min = 0, v_min = 0, u_max = 0, v_max = 0;
};

/// One bright spot of one frame. Positions are in the upright image (after the clip's rotation),
/// pixel (0, 0) being the centre of the top-left pixel.
struct Blob {
  int id = 0;  ///< unique within the frame, from 0
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d centre_sigma_px = Eigen::Vector2d::Constant(1.0);
  /// Linear light above the local background, in units of one pixel at nominal white, divided by the
  /// exposure (when the site gives it). A lower bound where `saturated`.
  double flux = 0.0;
  double flux_sigma = 0.0;
  int area_px = 0;       ///< pixels above the blob's threshold
  int saturated_px = 0;  ///< pixels at or above the clipping code
  PixelBox box;
  /// Standard deviation of the light about the centre along the image axes, px.
  Eigen::Vector2d spread_px = Eigen::Vector2d::Zero();
  /// Mean Cr and Cb of the blob's rim (where luma does not clip), fractions in [-0.5, 0.5]; 0 for grey clips.
  double cr = 0.0;
  double cb = 0.0;
  /// (row + 0.5) / rows - 0.5 in readout order, for the rolling shutter.
  double row_fraction = 0.0;
  Defect defects = Defect::none;
  LampKind kind = LampKind::other;  ///< first from this frame alone; the tracker may know better later
};

/// All blobs of one frame.
struct BlobFrame {
  std::int64_t frame = 0;
  CameraTime time;
  std::vector<Blob> blobs;
};

}  // namespace vildar
