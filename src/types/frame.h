#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "core/clock.h"

namespace vildar {

/// Read-only view of a luma plane as the decoder or driver gave it. Pixels are stored row by row in
/// readout order, before any rotation that the container asks for. 8-bit samples are bytes; deeper
/// ones are little-endian 16-bit words holding `bit_depth` significant low bits.
struct LumaView {
  std::shared_ptr<const void> owner;  ///< keeps the pixels alive
  const std::uint8_t* data = nullptr;
  std::ptrdiff_t stride_bytes = 0;
  int width_px = 0;
  int height_px = 0;
  int bit_depth = 8;
  /// Code values of black and of nominal white: 0 and 255 for full range, 16 and 235 for limited
  /// range, scaled to the bit depth. Codes outside occur and are meaningful.
  int black_code = 0;
  int white_code = 255;
  /// No code of row v is greater than row_maxima[v]; null where the source does not know, and of
  /// more than 8 bits. Kept alive by the owner as well.
  const std::uint8_t* row_maxima = nullptr;

  int bytes_per_sample() const { return bit_depth > 8 ? 2 : 1; }
  const std::uint8_t* row(int v) const { return data + v * stride_bytes; }
  /// Code value at column u, row v; both must lie inside the plane.
  int code(int u, int v) const {
    const std::uint8_t* sample = row(v) + u * bytes_per_sample();
    return bit_depth > 8 ? sample[0] | sample[1] << 8 : *sample;
  }
};

/// Chroma planes belonging to a LumaView; Cr is looked through for red lights, the rest is read only
/// inside blobs. Absent for grey clips.
struct ChromaView {
  const std::uint8_t* cb = nullptr;
  const std::uint8_t* cr = nullptr;
  std::ptrdiff_t stride_bytes = 0;
  int step_bytes = 1;  ///< between neighbouring samples of one plane: 1 planar, 2 interleaved
  int shift_u = 1;     ///< log2 of the horizontal subsampling
  int shift_v = 1;
  int bit_depth = 8;

  bool present() const { return cb != nullptr && cr != nullptr; }
  /// Code values at luma position (u, v); 2^(bit_depth - 1) is no colour.
  int cb_code(int u, int v) const { return code(cb, u, v); }
  int cr_code(int u, int v) const { return code(cr, u, v); }
  /// The same around zero, as fractions of full scale in [-0.5, 0.5].
  double cb_fraction(int u, int v) const { return fraction(cb_code(u, v)); }
  double cr_fraction(int u, int v) const { return fraction(cr_code(u, v)); }

 private:
  int code(const std::uint8_t* plane, int u, int v) const {
    const std::uint8_t* sample = plane + (v >> shift_v) * stride_bytes +
                                 (u >> shift_u) * step_bytes * (bit_depth > 8 ? 2 : 1);
    return bit_depth > 8 ? sample[0] | sample[1] << 8 : *sample;
  }
  double fraction(int code) const {
    const int middle = 1 << (bit_depth - 1);
    return static_cast<double>(code - middle) / (2.0 * middle);
  }
};

/// One picture of a clip or camera; shared and never written after it left its source.
struct Frame {
  std::int64_t index = 0;  ///< presentation order, from 0, damaged ones included
  CameraTime time;         ///< middle of the middle row's exposure
  LumaView luma;
  ChromaView chroma;
  int rotation_deg = 0;  ///< clockwise turn, 0/90/180/270, that shows the picture upright
  bool damaged = false;  ///< the decoder reported errors in it, or in one it may be predicted from
};

}  // namespace vildar
