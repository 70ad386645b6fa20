#pragma once

#include <vector>

#include "types/frame.h"
#include "types/site.h"

namespace vildar {

/// How a camera's code values answer to light. Linear light is 0 at black and 1 at nominal white;
/// codes above nominal white continue the curve, codes below black give 0.
class Response {
 public:
  /// sRGB, the usual curve of cameras that make 8-bit video.
  Response() = default;
  explicit Response(const CameraSite& site);

  /// `fraction` = (code - black) / (white - black).
  double linear_from_fraction(double fraction) const;
  /// Inverse of linear_from_fraction for linear >= 0.
  double fraction_from_linear(double linear) const;

  /// Linear light of every code value of a plane: 2^bit_depth entries.
  std::vector<float> table_for(const LumaView& luma) const;

 private:
  ResponseKind kind_ = ResponseKind::srgb;
  double exponent_ = 2.2;
  std::vector<double> table_;
};

}  // namespace vildar
